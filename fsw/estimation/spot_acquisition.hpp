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
  /// The work of one call is that of max_hypotheses, and of one refinement of a spot triple at most more. Two cameras: first the
  /// spots that both see; then, or with one camera, those of camera 0, those of the other one last.
  /// ok, ambiguous or not. unfinished: the next call with the same spots, settings and `out` goes on. no_data: every triple has
  /// been tried, nothing is better than chance. too_few_features: fewer than 4 spots in all or 3 in each camera, or fewer than 4
  /// markers; rank_deficient: markers on a line; invalid_argument: more than max_search_markers, a setting; not_configured: no
  /// camera. `out` is valid only if ok.
  Status acquire(const CameraRig& rig, const TargetModel& target, const RigSpots& spots,
                 const SpotSearchSettings& settings, const AttitudePrior& prior, AcquiredSpots& out);
  /// The next call starts from the beginning.
  void restart();
  /// The next call has the spots of a later frame: goes on where the search was, as the order of spots changes little from frame
  /// to frame.
  void change_spots();
  /// The next call begins with its spots.
  [[nodiscard]] bool is_new() const { return !has_spots_; }
  /// Found; other explanations are looked for. Other spots than those of the find are no use then.
  [[nodiscard]] bool is_weighing() const { return phase_ == Phase::weigh; }

 private:
  /// What is looked through.
  enum class Phase : std::uint8_t {
    mated,   ///< spots that both cameras see
    single,  ///< spots of one camera
    weigh,   ///< other explanations of what is explained
  };

  Status prepare(const SpotScene& scene);
  /// Spots to try next; false: the phase has no more.
  [[nodiscard]] bool open_next(const SpotScene& scene, const AcquiredSpots& out);
  [[nodiscard]] bool open_next_to_weigh(const SpotScene& scene, const AcquiredSpots& out);
  void begin_round(const SpotScene& scene, const AcquiredSpots& out);
  /// On to what comes after a phase without more spots. False: that was the last.
  [[nodiscard]] bool next_phase(const SpotScene& scene);
  void build_order(const SpotScene& scene);
  /// Refines the best of the trial. True: a pose is found.
  [[nodiscard]] bool close_trial(const SpotScene& scene, AcquiredSpots& out);
  void begin_weighing();
  Status conclude(const SpotScene& scene, AcquiredSpots& out);
  void offer(const SpotAgreement& candidate, AcquiredSpots& out);

  MarkerTriples triples_;
  std::array<SpotField, config::max_cameras> fields_;
  SpotMates mates_;
  SpotTriples order_;
  SpotTrial trial_;
  SpotAgreement candidate_;
  PoseObservations previous_;  ///< of its refinement
  bool has_other_ = false;
  bool has_spots_ = false;  ///< fields_ are those of the present spots
  bool has_order_ = false;  ///< and order_ is theirs
  int steps_ = 0;           ///< of the order, those of earlier spots included
  Phase phase_ = Phase::mated;
  std::uint16_t camera_ = 0;

  // Weighing: in each round two triples, without a common spot, of what the camera explains that explains most.
  int round_ = 0;
  int triples_of_round_ = 0;
  int least_hits_ = 0;
  PoseEstimate before_round_;
  std::array<std::uint8_t, config::max_spots> explained_{};
  std::size_t explained_count_ = 0;
};

}  // namespace relnav
