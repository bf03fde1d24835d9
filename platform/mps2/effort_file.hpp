#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

#include "platform/mps2/semihosting.hpp"

namespace relnav::platform::mps2 {

struct Effort {
  std::uint32_t steps = 0;
  std::uint32_t median = 0;
  std::uint32_t maximum = 0;
};

/// What each step took, in nanoseconds of the clock: with qemu's -icount shift=0, in instructions. `work` without the frame's
/// transfer, which a flight board leaves to its DMA.
class EffortFile {
 public:
  /// io_error: the file cannot be made.
  Status open(const char* path);
  void add(std::int64_t work, std::int64_t transfer);
  /// Of the work of all steps so far, the first 4096. Reorders what it keeps.
  [[nodiscard]] Effort summary();

 private:
  HostFile file_;
  std::array<std::uint32_t, 4096> works_{};
  std::size_t count_ = 0;
};

}  // namespace relnav::platform::mps2
