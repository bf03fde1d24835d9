#pragma once
#include <cstdint>
#include <span>

#include "fsw/base/status.hpp"
#include "fsw/geometry/light_spot.hpp"
#include "fsw/vision/image_view.hpp"
#include "fsw/vision/spot_regions.hpp"
#include "fsw/vision/spot_settings.hpp"
#include "fsw/vision/spot_threshold.hpp"

namespace relnav::vision {

/// What a search has seen besides the spots it returns. Anything dropped is for an event.
struct SpotReport {
  std::int32_t found = 0;            ///< candidates that passed the gate of size and shape
  std::int32_t overflow = 0;         ///< of these, the weaker ones beyond the capacity
  std::int32_t misfits = 0;          ///< of these, without the profile of a light spot
  std::int32_t repeated = 0;         ///< of these, on a stronger one's place (windows that overlap)
  std::int32_t rejected = 0;         ///< regions outside the gate
  std::int32_t dropped_runs = 0;     ///< bright runs for which there was no room, thresholds raised
  std::int32_t dropped_regions = 0;  ///< regions for which there was no room
  std::int32_t raised = 0;           ///< thresholds raised to make the runs fit

  [[nodiscard]] bool overflowed() const { return overflow > 0 || dropped_runs > 0 || dropped_regions > 0; }
};

/// Finds bright spots (lamps, markers) and their centroids: threshold from the surroundings (SpotThreshold), connected
/// regions and the gate of size and shape (SpotRegions), position by a fit to the unsaturated flank (fit_spot). Spots
/// narrower than the point spread or wider than about 20 px are none. About 200 kB: not for the stack. Same image and
/// settings, same spots: no state passes from one search to the next.
class LightSpotFinder {
 public:
  /// Status::invalid_argument, and no change, for settings outside their domain.
  Status configure(const SpotSettings& settings);

  /// Searches the whole image; spots strongest first. Status::not_configured; invalid_argument: not a valid view.
  Status find(const ImageView& image, LightSpots& spots, SpotReport& report);
  Status find(const ImageView16& image, LightSpots& spots, SpotReport& report);

  /// Searches windows, clipped to the image. A spot counts when the middle of it lies in a window, margin_px inside; its
  /// flank may lie outside. Thresholds come from the whole window, which is best three to five times as wide as the spot.
  Status find(const ImageView& image, std::span<const PixelRegion> windows, int margin_px, LightSpots& spots,
              SpotReport& report);
  Status find(const ImageView16& image, std::span<const PixelRegion> windows, int margin_px, LightSpots& spots,
              SpotReport& report);

 private:
  template <typename Pixel>
  Status search(const GreyImageView<Pixel>& image, std::span<const PixelRegion> windows, int margin_px,
                LightSpots& spots, SpotReport& report);
  template <typename Pixel>
  void fit_candidates(const GreyImageView<Pixel>& image, LightSpots& spots, SpotReport& report) const;

  SpotSettings settings_;
  bool configured_ = false;
  SpotThreshold threshold_;
  SpotRegions regions_;
  SpotCandidates candidates_;
};

}  // namespace relnav::vision
