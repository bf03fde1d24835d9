#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

#include "fsw/base/status.hpp"
#include "fsw/math/types.hpp"
#include "fsw/vision/image_view.hpp"
#include "fsw/vision/patch.hpp"

namespace relnav::vision {

inline constexpr int max_search_half_px = 40;
inline constexpr int max_search_side_px = 2 * max_search_half_px + 1;

struct SearchOptions {
  double chi_square = 9.21;            ///< gate, 2 degrees of freedom: 99 %
  std::int32_t full_scan_limit = 600;  ///< ellipses of more pixels are first scanned on a lattice of every second pixel
};

struct SearchResult {
  int u_px = 0;  ///< best position
  int v_px = 0;
  double score = -1.0;         ///< correlation there, -1..1; 0 where the image is flat
  double second_score = -1.0;  ///< best further than 3 px away in u or v; -1 when there is none
  std::int32_t positions = 0;  ///< evaluated
  bool capped = false;         ///< the ellipse was cut at max_search_half_px
  bool on_lattice = false;     ///< scanned coarsely first
};

/// Working memory of search(); contents are of no interest to the caller.
struct SearchScratch {
  static constexpr int region_stride = max_search_side_px + window_stride - 1;
  alignas(16) std::array<std::int16_t,
                         static_cast<std::size_t>((max_search_side_px + window_side_px - 1) * region_stride)> region{};
  std::array<std::int16_t, static_cast<std::size_t>(max_search_side_px* max_search_side_px)> scores_q14{};
};

/// Zero-mean normalised cross-correlation of the patch with the window about pixel (u, v), which lies inside the image.
[[nodiscard]] double correlation_at(const WarpedPatch& patch, const ImageView& image, int u_px, int v_px);

/// Best correlation among the pixels d with (d - uv)' S^-1 (d - uv) <= chi_square and the 3 x 3 about uv. Among equals the
/// first in raster order (of the lattice first, when it is used). outside_domain: no window of the region lies inside the
/// image; not_positive_definite: S; not_finite.
[[nodiscard]] Status search(const WarpedPatch& patch, const ImageView& image, const Vec2& uv_px, const Mat2& S_px2,
                            const SearchOptions& options, SearchScratch& scratch, SearchResult& result);

}  // namespace relnav::vision
