#pragma once
#include "fsw/estimation/marker_triples.hpp"
#include "fsw/estimation/spot_agreement.hpp"
#include "fsw/estimation/spot_hypotheses.hpp"
#include "fsw/estimation/spot_triples.hpp"

namespace relnav {

/// What an acquisition found. The observations name the marker of each spot used.
struct AcquiredSpots {
  SpotAgreement best;
  bool ambiguous = false;
  SpotAgreement other;  ///< valid if ambiguous: the best of the poses that are not excluded
  SearchEffort effort;  ///< of this call
};

/// Pose of a target from light spots that look all the same, among clutter, with markers missing, in one or two cameras; no
/// prior, or an attitude to stay near to.
///
/// Three spots taken as three markers give up to four poses (Lambda Twist); each is held against the other spots, the best
/// of a spot triple are refined by least squares. A pose is believed when its residuals fit and when so many spots so close
/// to the predicted images are not to be expected by chance among all the poses tried (number of false alarms: Moisan,
/// Stival, "A probabilistic criterion to detect rigid point matches", IJCV 57(3), 2004). Then every other way to explain
/// the spots is looked for, starting from two triples of those explained: symmetric targets, the second minimum of planar and
/// distant ones, layouts that repeat. One that costs less than ambiguous_chi2 more is given beside the best.
///
/// Limits: a mirrored target is told from the right one by perspective alone, and is excluded as far as the noise lets it
/// be. Four markers in one camera cannot be told from chance among clutter.
/// Deterministic; scratch lives in the object (about 0.15 MB).
class SpotAcquisition {
 public:
  /// The search of one call ends after max_hypotheses (plus at most those of one spot triple); the next one goes on where it
  /// ended, as the order of the spots changes little from frame to frame. Camera 0 first, the other if that has
  /// too few spots or every triple of it has been tried.
  /// ok, ambiguous or not; too_few_features: fewer than 4 spots in all or 3 in each camera, or fewer than 4 markers;
  /// rank_deficient: markers on a line; invalid_argument: more than max_search_markers, a setting; not_configured: no camera;
  /// no_data: nothing found that is better than chance. `out` is valid only if ok.
  Status acquire(const CameraRig& rig, const TargetModel& target, const RigSpots& spots,
                 const SpotSearchSettings& settings, const AttitudePrior& prior, AcquiredSpots& out);
  /// The next call starts from the beginning.
  void restart() {
    steps_ = 0;
    camera_ = 0;
  }

 private:
  Status search(const SpotScene& scene, std::uint16_t camera, AcquiredSpots& out);
  /// Other explanations of what is explained; the cheapest becomes the best.
  void look_for_others(const SpotScene& scene, AcquiredSpots& out);
  void offer(const SpotAgreement& candidate, AcquiredSpots& out);

  MarkerTriples triples_;
  std::array<SpotField, config::max_cameras> fields_;
  SpotTriples order_;
  SpotAgreement candidate_;
  PoseObservations previous_;  ///< of its refinement
  bool has_other_ = false;
  int steps_ = 0;  ///< where the next call goes on
  std::uint16_t camera_ = 0;
};

}  // namespace relnav
