#pragma once
#include <cstdint>
#include <fstream>
#include <string>
#include <vector>

#include "hal/frame.hpp"
#include "hal/raw_container.hpp"

namespace relnav::hil {

/// Writes a raw container (hal/raw_container.hpp), frame by frame. Throws InputError when the file cannot be written.
class RawContainerWriter {
 public:
  explicit RawContainerWriter(const std::string& path);
  /// `gain`: of the sensor; 0: not known.
  void add(const hal::Frame& frame, double gain = 0.0);
  /// Index and file header; without them the file is no container.
  void finish();

 private:
  void write(const void* bytes, std::size_t size);

  std::string path_;
  std::ofstream file_;
  std::vector<std::uint64_t> offsets_;
};

}  // namespace relnav::hil
