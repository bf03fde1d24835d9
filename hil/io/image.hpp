#pragma once
#include <cstdint>
#include <string>
#include <vector>

namespace relnav::hil {

/// Grey image, rows top to bottom, without padding. 16-bit samples are in the machine's byte order.
struct Image {
  std::uint32_t width_px = 0;
  std::uint32_t height_px = 0;
  std::uint32_t bytes_per_pixel = 1;  ///< 1 or 2
  std::vector<std::uint8_t> bytes;
};

/// Reads a PNG file. Palette and colour become grey (luma 0.299 R + 0.587 G + 0.114 B), transparency is dropped.
/// Throws InputError when the file is missing, no PNG, truncated or damaged.
[[nodiscard]] Image read_png(const std::string& path);

/// Of a 16-bit image the upper bytes; an 8-bit one stays as it is.
void keep_upper_bytes(Image& image);

enum class PngEffort : std::uint8_t {
  small,  ///< ten times as long as fast
  fast,
};

/// PNG bytes of a grey image. Throws std::runtime_error.
[[nodiscard]] std::vector<std::uint8_t> encode_png(const Image& image, PngEffort effort = PngEffort::small);
/// Into a file, fast. Throws InputError: it cannot be written.
void write_png(const std::string& path, const Image& image);

}  // namespace relnav::hil
