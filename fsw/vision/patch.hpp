#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

#include "fsw/base/status.hpp"
#include "fsw/math/types.hpp"
#include "fsw/vision/image_view.hpp"

namespace relnav::vision {

inline constexpr int window_half_px = 6;  ///< matching window: 13 x 13
inline constexpr int window_side_px = 2 * window_half_px + 1;
inline constexpr int window_stride = 16;  ///< rows are padded with zeros to whole vectors
inline constexpr int window_pixels = window_side_px * window_side_px;
inline constexpr int reference_half_px = 17;  ///< stored patch: 35 x 35, the border is for warping
inline constexpr int reference_side_px = 2 * reference_half_px + 1;
inline constexpr int level_scale = 8;  ///< grey levels are kept in eighths (Q3)
static_assert(window_side_px <= window_stride);

/// What a feature looked like when first seen; its position is the centre pixel.
struct ReferencePatch {
  std::array<std::uint8_t, static_cast<std::size_t>(reference_side_px* reference_side_px)> levels{};
};

/// One number per pixel of the matching window; row r begins at r * window_stride.
using WindowArray = std::array<std::int16_t, static_cast<std::size_t>(window_side_px* window_stride)>;

/// What the patch should look like in the current image.
struct WarpedPatch {
  alignas(16) WindowArray level_q3{};       ///< grey level
  alignas(16) WindowArray gradient_u_q3{};  ///< level(u + 1) - level(u - 1)
  alignas(16) WindowArray gradient_v_q3{};  ///< level(v + 1) - level(v - 1)
  alignas(16) WindowArray unsaturated{};    ///< -1: made of levels under saturated_level only; else 0
  std::int32_t sum_q3 = 0;                  ///< of level_q3
  std::int64_t variance_q6 = 0;             ///< window_pixels * sum of squares - square of the sum
};

/// Bounds within which a predicted appearance is worth trying.
struct WarpLimits {
  double max_area_change = 4.0;  ///< determinant within [1 / this, this]
  double max_stretch = 2.5;      ///< root of the sum of the squared elements of the warp, divided by sqrt(2)
};

/// Copies the patch about pixel (u, v). outside_domain: it does not lie wholly inside the image.
[[nodiscard]] Status capture_patch(const ImageView& image, int u_px, int v_px, ReferencePatch& patch);

/// Resamples the patch (cubic convolution, 8 fractional bits) with current offset = warp * reference offset.
/// outside_domain: the warp is beyond the limits or needs pixels beyond the stored border; not_finite.
[[nodiscard]] Status warp_patch(const ReferencePatch& reference, const Mat2& warp, const WarpLimits& limits,
                                WarpedPatch& patch);

}  // namespace relnav::vision
