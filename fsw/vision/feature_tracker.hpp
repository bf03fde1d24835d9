#pragma once
#include <array>
#include <cstdint>

#include "fsw/base/bounded_vector.hpp"
#include "fsw/base/slot_pool.hpp"
#include "fsw/base/status.hpp"
#include "fsw/config.hpp"
#include "fsw/geometry/feature_exchange.hpp"
#include "fsw/vision/correlation.hpp"
#include "fsw/vision/image_view.hpp"
#include "fsw/vision/patch.hpp"
#include "fsw/vision/subpixel.hpp"

namespace relnav::vision {

/// What became of one predicted feature.
enum class MatchOutcome : std::uint8_t {
  matched,
  low_score,      ///< no position in the search region correlates well enough
  ambiguous,      ///< another position correlates nearly as well
  outside_image,  ///< no window of the search region lies inside the image
  not_matchable,  ///< flat patch, or seen too differently from its first view to be warped
  not_refined,    ///< no sub-pixel position near the integer one
  no_patch,       ///< nothing stored for this handle
  bad_prediction  ///< not finite, or its covariance is not positive definite
};

struct TrackerOptions {
  double min_score = 0.75;        ///< correlation at the integer peak
  double max_second_ratio = 1.0;  ///< second best over best, further than 3 px away; 1 switches the test off
  WarpLimits warp;
  SearchOptions search;
  SubpixelOptions subpixel;
};

struct MatchReport {
  BoundedVector<MatchOutcome, config::max_features> outcomes;  ///< one per prediction, in their order
  std::uint32_t matched = 0;
  std::uint32_t positions = 0;   ///< correlations computed
  std::uint32_t capped = 0;      ///< search regions cut at max_search_half_px
  std::uint32_t on_lattice = 0;  ///< search regions scanned coarsely first
  std::uint32_t quadratic = 0;   ///< positions from the quadratic fit
  std::uint32_t iterations = 0;  ///< of the sub-pixel refinement, all features
};

/// Finds features again by the patch of their first view. Fixed memory, one patch per slot of the filter.
class FeatureTracker {
 public:
  explicit FeatureTracker(const TrackerOptions& options = {}) : options_(options) {}
  /// Takes the options and forgets every patch. In place: a new tracker would need its 100 KiB on the stack.
  void configure(const TrackerOptions& options) {
    options_ = options;
    clear();
  }

  /// Captures the patch about (u, v); replaces whatever the slot held. invalid_argument: slot index or image;
  /// outside_domain: nearer than reference_half_px to the image's edge (the slot is then empty).
  Status store(SlotHandle slot, const ImageView& image, int u_px, int v_px);
  /// Forgets the patch. stale_handle: the slot holds nothing, or another use's patch.
  Status drop(SlotHandle slot);
  void clear();
  [[nodiscard]] bool holds(SlotHandle slot) const;

  /// Looks for every prediction and replaces `matches` (in the order of the predictions) and `report`.
  /// invalid_argument: unusable image.
  Status match(const ImageView& image, const FeaturePredictions& predictions, FeatureMatches& matches,
               MatchReport& report);

 private:
  struct Entry {
    SlotHandle slot;
    bool stored = false;
    ReferencePatch patch;
  };

  MatchOutcome match_one(const ImageView& image, const FeaturePrediction& prediction, FeatureMatch& match,
                         MatchReport& report);

  TrackerOptions options_;
  std::array<Entry, config::max_features> entries_{};
  WarpedPatch warped_;
  SearchScratch scratch_;
};

}  // namespace relnav::vision
