#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

#include "fsw/base/bounded_vector.hpp"
#include "fsw/config.hpp"
#include "fsw/math/types.hpp"
#include "fsw/vision/image_view.hpp"
#include "fsw/vision/spot_settings.hpp"
#include "fsw/vision/spot_threshold.hpp"

namespace relnav::vision {

/// A connected region (8 neighbours) that has passed the gate of size and shape.
struct SpotCandidate {
  Vec2 uv_px = Vec2::Zero();           ///< centroid of the levels above the threshold
  Vec2 half_streak_px = Vec2::Zero();  ///< from the middle to the end of the path of a spot blurred by motion
  double flux_dn = 0.0;                ///< sum of the levels above the first threshold tried
  double peak_dn = 0.0;
  std::int32_t area_px = 0;
  std::int32_t saturated_px = 0;
};

/// The strongest candidates, by flux; among equals the first in raster order.
class SpotCandidates {
 public:
  void clear() {
    kept_.clear();
    found_ = 0;
  }
  void put(const SpotCandidate& candidate);
  [[nodiscard]] const BoundedVector<SpotCandidate, config::max_spots>& kept() const { return kept_; }
  [[nodiscard]] std::int32_t found() const { return found_; }

 private:
  BoundedVector<SpotCandidate, config::max_spots> kept_;
  std::int32_t found_ = 0;
};

/// What the tables and the gate have left out.
struct RegionCounts {
  std::int32_t rejected = 0;         ///< regions outside the gate, at every level tried
  std::int32_t dropped_runs = 0;     ///< for want of room
  std::int32_t dropped_regions = 0;  ///< likewise
  std::int32_t raised = 0;           ///< thresholds raised because the runs did not fit
};

/// Connected regions of bright pixels: horizontal runs (16 pixels at a time), joined by union-find over the run table in
/// one pass (He, Chao, Suzuki, IEEE Trans. Image Processing 17(5), 2008). A region outside the gate, or one judged close
/// above the background, is looked at again above a higher level, within its own runs: that parts a spot from the
/// structure or the glint it touches. So often as max_levels; every pass is bounded by the tables.
class SpotRegions {
 public:
  /// The region lies inside the image; `threshold` was measured on it and may be raised. Spots whose middle lies outside of
  /// `core` are left out.
  void find(const ImageView& image, const PixelRegion& region, const PixelRegion& core, const SpotSettings& settings,
            SpotThreshold& threshold, SpotCandidates& candidates, RegionCounts& counts);
  void find(const ImageView16& image, const PixelRegion& region, const PixelRegion& core, const SpotSettings& settings,
            SpotThreshold& threshold, SpotCandidates& candidates, RegionCounts& counts);

 private:
  struct Run {
    std::uint16_t u0_px = 0;
    std::uint16_t u1_px = 0;  ///< one after the last
    std::uint16_t v_px = 0;
    std::uint16_t level_dn = 0;        ///< its pixels are above
    std::uint16_t first_level_dn = 0;  ///< before it was raised
    std::uint16_t parent = 0;          ///< run of the same region, not after this one; then the number of the region
  };
  struct Region {
    std::int32_t area = 0;
    std::int32_t saturated = 0;
    std::uint16_t level_dn = 0;
    std::uint16_t first_level_dn = 0;
    std::uint16_t peak_dn = 0;
    std::uint16_t next_level_dn = 0;  ///< 0: done with
    std::uint16_t u0_px = 0;          ///< origin of the sums
    std::uint16_t v0_px = 0;
    double total = 0.0;                                     ///< above the first threshold
    double flux = 0.0, flux_u = 0.0, flux_v = 0.0;          ///< weighted with the level above the threshold
    double u = 0.0, v = 0.0, uu = 0.0, uv = 0.0, vv = 0.0;  ///< over the pixels
  };
  using Runs = BoundedVector<Run, config::max_spot_runs>;
  static_assert(config::max_spot_runs <= 65536 && config::max_spot_regions < 65536);

  template <typename Pixel>
  void search(const GreyImageView<Pixel>& image, const PixelRegion& region, const PixelRegion& core,
              const SpotSettings& settings, SpotThreshold& threshold, SpotCandidates& candidates, RegionCounts& counts);
  template <typename Pixel>
  std::int32_t scan(const GreyImageView<Pixel>& image, const PixelRegion& region, const SpotThreshold& threshold);
  template <typename Pixel>
  void measure(const GreyImageView<Pixel>& image, const SpotSettings& settings, RegionCounts& counts);
  template <typename Pixel>
  void split(const GreyImageView<Pixel>& image, RegionCounts& counts);
  bool judge(const PixelRegion& core, const SpotSettings& settings, bool last, SpotCandidates& candidates,
             RegionCounts& counts);
  void connect();
  [[nodiscard]] std::uint16_t root_of(std::uint16_t run);
  void join(std::uint16_t a, std::uint16_t b);

  std::array<Runs, 2> tables_;
  std::size_t current_ = 0;
  BoundedVector<Region, config::max_spot_regions> regions_;
};

}  // namespace relnav::vision
