#include "hil/serve/image_fault.hpp"

#include <algorithm>

namespace relnav::hil {

void fill(Image& image, std::uint8_t value) { std::fill(image.bytes.begin(), image.bytes.end(), value); }

void tear(Image& image, const Image& lower) {
  const std::size_t row_bytes = std::size_t{image.width_px} * image.bytes_per_pixel;
  const auto half = static_cast<std::ptrdiff_t>(image.height_px / 2 * row_bytes);
  std::copy(lower.bytes.begin() + half, lower.bytes.end(), image.bytes.begin() + half);
}

}  // namespace relnav::hil
