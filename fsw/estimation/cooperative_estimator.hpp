#pragma once
#include <cstdint>

#include "fsw/estimation/pose_outliers.hpp"
#include "fsw/estimation/stereo_closed_form.hpp"

namespace relnav {

enum class CooperativeMethod : std::uint8_t {
  least_squares,  ///< maximum likelihood over all cameras: `rodrigues` with one camera, `ml` with two
  motor,  ///< closed forms for comparison, two cameras; their covariance is their own, see propagate_pixel_noise()
  orthogonal,
};

struct CooperativeConfig {
  CooperativeMethod method = CooperativeMethod::least_squares;
  MotorLines lines = MotorLines::target;
  AcquisitionSettings acquisition;
  OutlierSettings outliers;
  /// A previous pose this near (rad) speaks for one of two minima when the other is twice as far.
  double prior_cone_rad = 0.35;
};

/// What an epoch of identified observations says.
struct CooperativeSolution {
  PoseEstimate estimate;
  PoseEstimate other;  ///< the second minimum; valid with Status::ambiguous
  ObservationMask used{};
  bool acquired = false;  ///< found without the previous pose
};

/// Pose of a cooperative target from identified features in one or two cameras: start (previous pose, motor, or acquisition),
/// maximum likelihood, both minima of a flat target, outliers left out, chi-square judged. No state from epoch to epoch.
class CooperativeEstimator {
 public:
  /// invalid_argument: no camera, fewer than 3 features, or a closed form asked of one camera.
  Status configure(const CooperativeConfig& config, const CameraRig& rig, const TargetModel& target);

  /// `prior`: where the target is expected in this epoch; null: not known.
  /// ok; ambiguous: two poses explain the observations and no prior decides, both are in `out`; inconsistent: chi-square
  /// alarm that no few observations explain (`out.estimate` is the best there is, not to be used; a closed form does not look
  /// for outliers), or two cameras whose rays do not meet (no estimate); else as solve_pose() and
  /// acquire_pose(), without a pose.
  Status solve(const PoseObservations& observations, const Pose* prior, CooperativeSolution& out) const;

  [[nodiscard]] const CameraRig& rig() const { return rig_; }
  [[nodiscard]] const TargetModel& target() const { return target_; }
  [[nodiscard]] const CooperativeConfig& config() const { return config_; }

 private:
  Status solve_closed_form(const PoseObservations& observations, CooperativeSolution& out) const;
  /// The best pose from the prior, else from the motor, else from nothing.
  Status find_minimum(const PoseObservations& observations, const Pose* prior, CooperativeSolution& out) const;
  /// Looks for the other minimum of a flat target seen by one camera.
  [[nodiscard]] Status weigh_minima(const PoseObservations& observations, const Pose* prior,
                                    CooperativeSolution& out) const;
  [[nodiscard]] bool is_one_camera(const PoseObservations& observations) const;

  CooperativeConfig config_;
  CameraRig rig_;
  TargetModel target_;
};

}  // namespace relnav
