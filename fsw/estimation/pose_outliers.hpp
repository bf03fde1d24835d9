#pragma once
#include "fsw/estimation/pose_acquisition.hpp"

namespace relnav {

struct OutlierSettings {
  double alarm_z = 4.0;      ///< chi-square beyond this point (of a normal, 3e-5) is an alarm
  double gate_sigma = 4.5;   ///< an observation further off than this does not belong to a pose
  double least_share = 0.6;  ///< of the observations must remain
  int max_hypotheses = 48;   ///< subsets of four that are tried
  std::uint64_t seed = 1;
};

/// Whether the residuals are larger than their sigmas allow.
[[nodiscard]] bool is_alarming(const PoseEstimate& estimate, const OutlierSettings& settings);

/// Pose in spite of wrong observations. First the worst one is left out, one by one; if that does not calm chi-square,
/// subsets of four, drawn with a fixed seed, are acquired and the pose most observations agree with is kept (Fischler, Bolles
/// 1981). Bounded by max_hypotheses acquisitions. `used` tells which observations count, before and after.
/// ok; inconsistent: chi-square cannot be calmed with least_share of the observations and 5 of them at least;
/// too_few_features: fewer than 5 observations, so that nothing can be told; else as solve_pose(). On an error `out` and
/// `used` are untouched.
Status reject_outliers(const CameraRig& rig, const TargetModel& target, const PoseObservations& observations,
                       const Pose& start, const AcquisitionSettings& acquisition, const OutlierSettings& settings,
                       ObservationMask& used, PoseEstimate& out);

}  // namespace relnav
