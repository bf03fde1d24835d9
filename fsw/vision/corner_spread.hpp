#pragma once
#include <cstddef>
#include <cstdint>
#include <span>

#include "fsw/base/bounded_vector.hpp"
#include "fsw/config.hpp"
#include "fsw/geometry/feature_exchange.hpp"
#include "fsw/math/types.hpp"
#include "fsw/vision/fast_corners.hpp"
#include "fsw/vision/image_view.hpp"

namespace relnav::vision {

struct SpreadOptions {
  int cell_px = 40;               ///< side of a grid cell, at least 16; larger where that needs over 240 cells
  double min_distance_px = 12.0;  ///< to tracked features and between candidates
  int border_px = 17;             ///< candidates keep this far from the image's edge; at least reference_half_px
  std::int32_t min_score =
      400;  ///< least minimum eigenvalue, in squared levels per pixel times 100: 400 is (2 levels)^2
  std::int32_t good_score = 40000;  ///< from here on a better corner is not preferred to a better spread
  int max_saturated = 50;           ///< over-exposed pixels allowed in the matching window
};

using CornerCandidates = BoundedVector<CornerCandidate, config::max_features>;

inline constexpr int corner_reach_px = 10;

/// Minimum eigenvalue of the mean of g g' over the matching window about (u, v), times 100 (Shi, Tomasi, CVPR 1994);
/// g: half central differences of neighbours that are not over-exposed (zero otherwise), levels per pixel. Integer
/// arithmetic, rounded down. The square of half side corner_reach_px about (u, v) lies inside the image.
[[nodiscard]] std::int32_t corner_strength(const ImageView& image, int u_px, int v_px);

/// Picks up to `wanted` of the corners as new features: best first, where a corner counts less the more features its grid
/// cell holds already. Ties: stronger, then first in raster order of the corners. Corners weaker than min_score are left.
/// invalid_argument: unusable image or options.
[[nodiscard]] Status select_corners(const ImageView& image, std::span<const FastCorner> corners,
                                    std::span<const Vec2> tracked_px, std::size_t wanted, const SpreadOptions& options,
                                    CornerCandidates& candidates);

}  // namespace relnav::vision
