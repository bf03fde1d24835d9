#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "hal/frame.hpp"
#include "hal/raw_container.hpp"
#include "hil/io/file_handle.hpp"

struct iovec;

namespace relnav::hil {

/// Writes a raw container (hal/raw_container.hpp), frame by frame. What sync() has confirmed survives a loss of power.
/// Throws InputError when the file cannot be written: the frame at hand is taken back then, all before it stay readable, and
/// finish() may still be called. Where files are limited in size (RLIMIT_FSIZE) the program has to ignore SIGXFSZ.
class RawContainerWriter {
 public:
  /// An existing file is replaced.
  explicit RawContainerWriter(const std::string& path);
  /// `gain`: of the sensor; 0: not known.
  void add(const hal::Frame& frame, double gain = 0.0);
  /// All frames added so far are on the disk afterwards.
  void sync();
  /// Index and file header, on the disk. Without them a reader has to search for the frames.
  void finish();

  [[nodiscard]] const std::string& path() const { return path_; }
  /// Of the file so far.
  [[nodiscard]] std::uint64_t bytes() const { return end_; }

 private:
  /// All of the pieces, at `offset`; false: errno says why.
  [[nodiscard]] bool write(std::vector<iovec> pieces, std::uint64_t offset);
  [[noreturn]] void fail();
  /// Cuts off what an unfinished write has left, then fails.
  [[noreturn]] void take_back();

  std::string path_;
  FileHandle file_;
  std::uint64_t end_ = sizeof(hal::raw::FileHeader);  ///< of the last whole frame
  std::vector<std::uint64_t> offsets_;
  std::vector<std::uint8_t> rows_;  ///< of a frame whose rows have gaps
};

}  // namespace relnav::hil
