#pragma once
#include <cstddef>
#include <cstdint>
#include <span>

#include "fsw/base/status.hpp"
#include "fsw/vision/image_view.hpp"

namespace relnav::vision {

/// A pixel that passed the segment test.
struct FastCorner {
  std::uint16_t u_px = 0;
  std::uint16_t v_px = 0;
  std::uint8_t score = 0;  ///< largest threshold at which it still is a corner
  friend constexpr bool operator==(const FastCorner&, const FastCorner&) = default;
};

struct FastOptions {
  std::uint8_t threshold = 20;
  bool suppress_non_maxima = true;  ///< keep only scores above all 8 neighbours'
  PixelRegion region;               ///< centres considered; scores outside it count as 0 in the suppression
};

struct FastResult {
  Status status = Status::ok;  ///< no_capacity: more corners than room; invalid_argument: unusable image
  std::size_t count = 0;       ///< corners written, in raster order
  std::size_t found = 0;       ///< corners in the image
};

/// FAST-9/16 (Rosten, Drummond, ECCV 2006): at least 9 contiguous pixels of the circle of 16 about the centre p (radius 3)
/// all > p + threshold or all < p - threshold. When there is no room for all, the strongest are written; among equals the
/// first in raster order.
[[nodiscard]] FastResult detect_fast(const ImageView& image, const FastOptions& options, std::span<FastCorner> corners);

}  // namespace relnav::vision
