#pragma once
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

#include "fsw/base/crc32.hpp"
#include "hal/frame.hpp"

/// Raw container (.rnc): frames of one camera as the driver gave them, for recording and for feeding a target that has no image
/// formats. All numbers little-endian:
///   FileHeader | FrameHeader, pixels | FrameHeader, pixels | ... | one std::uint64_t a frame: where its FrameHeader begins
/// The file header is written last: a recording that was cut short has none, its frames can still be found one by one.
namespace relnav::hal::raw {

static_assert(std::endian::native == std::endian::little, "headers are read and written as they lie in memory");

inline constexpr std::array<char, 4> file_magic{'R', 'N', 'C', '1'};
inline constexpr std::array<char, 4> frame_magic{'F', 'R', 'M', 'E'};

struct FileHeader {
  std::array<char, 4> magic = file_magic;
  std::uint32_t frames = 0;
  std::uint64_t index_offset = 0;
  std::uint32_t index_crc = 0;
  std::array<std::uint32_t, 2> reserved{};
  std::uint32_t crc = 0;  ///< over all before
};

struct FrameHeader {
  std::array<char, 4> magic = frame_magic;
  std::uint32_t sequence = 0;
  std::int64_t mid_exposure_ns = 0;
  std::int64_t first_data_ns = 0;
  std::int64_t dequeued_ns = 0;
  std::int64_t exposure_ns = 0;
  double gain = 0.0;  ///< of the sensor, as its driver states it; 0: not known
  std::uint32_t width_px = 0;
  std::uint32_t height_px = 0;
  PixelFormat format = PixelFormat::mono8;
  ClockId clock = ClockId::monotonic;
  std::uint16_t status = 0;       ///< 0: whole; else what the driver said (a Status), without use
  std::uint32_t pixel_bytes = 0;  ///< after this header, rows without gaps
  std::uint32_t pixel_crc = 0;
  std::uint32_t crc = 0;  ///< over all before
};

static_assert(sizeof(FileHeader) == 32 && sizeof(FrameHeader) == 72, "no padding: the layout is the file's");

template <typename Header>
[[nodiscard]] std::uint32_t crc_of(const Header& header) {
  const auto bytes = std::bit_cast<std::array<std::uint8_t, sizeof(Header)>>(header);
  return crc32(std::span(bytes).first(sizeof(Header) - sizeof(header.crc)));
}

[[nodiscard]] inline bool is_whole(const FileHeader& header) {
  return header.magic == file_magic && header.crc == crc_of(header);
}
/// Also: the pixels are as many as the size says.
[[nodiscard]] inline bool is_whole(const FrameHeader& header) {
  const std::uint64_t bytes_per_pixel = header.format == PixelFormat::mono16 ? 2 : 1;
  return header.magic == frame_magic && header.crc == crc_of(header) &&
         header.pixel_bytes == bytes_per_pixel * header.width_px * header.height_px;
}

}  // namespace relnav::hal::raw
