#pragma once
#include <array>

#include "fsw/base/time.hpp"
#include "platform/mps2/semihosting.hpp"

namespace relnav::platform::mps2 {

/// trajectory.tum, byte for byte as hil/io/trajectory.cpp writes it (tests/target compares them).
class TrajectoryFile {
 public:
  /// io_error: the file cannot be made.
  Status open(const char* path);
  /// Of the target in the camera: position (m) and unit quaternion (x y z w, w >= 0). io_error.
  Status add(Time time, const std::array<double, 3>& t_CT, const std::array<double, 4>& q_CT);

 private:
  HostFile file_;
};

}  // namespace relnav::platform::mps2
