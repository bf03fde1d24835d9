#pragma once
#include <cstddef>
#include <cstdint>

#include "fsw/config.hpp"

namespace relnav::vision {

/// Grey image owned by somebody else. Rows are `stride` pixels apart; pixel (u, v) is pixels[v * stride + u].
template <typename Pixel>
struct GreyImageView {
  const Pixel* pixels = nullptr;
  int width = 0;
  int height = 0;
  int stride = 0;

  /// Non-empty, rows that do not overlap, within the configured maximum size.
  [[nodiscard]] constexpr bool is_valid() const {
    return pixels != nullptr && width > 0 && height > 0 && stride >= width &&
           static_cast<std::size_t>(width) <= config::max_image_width &&
           static_cast<std::size_t>(height) <= config::max_image_height;
  }
  /// Pointer to pixel (u, v); the caller keeps it inside the image.
  [[nodiscard]] constexpr const Pixel* at(int u_px, int v_px) const {
    return pixels + static_cast<std::ptrdiff_t>(v_px) * stride + u_px;
  }
  /// Whether the square of half side `half_px` about (u, v) lies inside the image.
  [[nodiscard]] constexpr bool contains(int u_px, int v_px, int half_px) const {
    return u_px >= half_px && v_px >= half_px && u_px < width - half_px && v_px < height - half_px;
  }
};

using ImageView = GreyImageView<std::uint8_t>;
using ImageView16 = GreyImageView<std::uint16_t>;  ///< deeper sensors; in the byte order of the processor

/// Rectangle of pixels, half open: u0 <= u < u1, v0 <= v < v1.
struct PixelRegion {
  int u0_px = 0;
  int v0_px = 0;
  int u1_px = static_cast<int>(config::max_image_width);
  int v1_px = static_cast<int>(config::max_image_height);

  [[nodiscard]] constexpr bool holds(double u_px, double v_px) const {
    return u_px >= u0_px && u_px < u1_px && v_px >= v0_px && v_px < v1_px;
  }
};

/// A level from here on counts as over-exposed.
inline constexpr std::uint8_t saturated_level = 250;

}  // namespace relnav::vision
