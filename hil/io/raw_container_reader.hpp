#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "hal/raw_container.hpp"
#include "hil/io/file_handle.hpp"
#include "hil/io/image.hpp"

namespace relnav::hil {

/// Reads a raw container (hal/raw_container.hpp): by its index, or, where that is missing or damaged, by searching frame by
/// frame. Frames with a damaged header are left out and named in notes(). Nothing is believed that has no right checksum.
class RawContainerReader {
 public:
  struct Place {
    hal::raw::FrameHeader header;
    std::uint64_t offset = 0;  ///< of the header in the file
  };

  /// Throws InputError: no such file, or no raw container.
  explicit RawContainerReader(const std::string& path);

  [[nodiscard]] const std::string& path() const { return path_; }
  /// In the order of the file. Pixels have not been looked at yet.
  [[nodiscard]] const std::vector<Place>& frames() const { return frames_; }
  /// The recording was never finished (loss of power, disk full): frames() are all that are whole.
  [[nodiscard]] bool is_cut() const { return cut_; }
  /// One line for each thing that is not as it should be.
  [[nodiscard]] const std::vector<std::string>& notes() const { return notes_; }

  /// Throws InputError: checksum of the pixels is wrong, or the file cannot be read.
  [[nodiscard]] Image image(std::size_t frame) const;
  [[nodiscard]] bool has_good_pixels(std::size_t frame) const { return has_good_pixels(frames_[frame]); }
  /// "FILE: frame K at byte N", for messages. K counts from 0 as in frames().
  [[nodiscard]] std::string place_text(std::size_t frame) const;

 private:
  /// False: the file ends before.
  bool read(void* bytes, std::size_t size, std::uint64_t offset) const;
  [[nodiscard]] std::vector<std::uint8_t> pixels(const Place& place) const;
  [[nodiscard]] bool read_frame_header(std::uint64_t offset, std::uint64_t end, Place& place) const;
  [[nodiscard]] bool has_good_pixels(const Place& place) const;
  bool read_by_index(const hal::raw::FileHeader& header);
  /// All frames from the begin to `end`; returns where the last one ends.
  std::uint64_t search(std::uint64_t end);
  /// Offset of the next whole frame header from `offset` on; `end`: there is none.
  [[nodiscard]] std::uint64_t next_frame(std::uint64_t offset, std::uint64_t end) const;
  [[nodiscard]] bool is_index(std::uint64_t offset) const;
  /// Of a recording that was cut off, the last pixels may not have reached the disk.
  void drop_unwritten();

  std::string path_;
  FileHandle file_;
  std::uint64_t bytes_ = 0;
  std::vector<Place> frames_;
  std::vector<std::string> notes_;
  bool cut_ = false;
};

}  // namespace relnav::hil
