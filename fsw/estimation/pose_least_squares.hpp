#pragma once
#include <array>

#include "fsw/geometry/camera_rig.hpp"
#include "fsw/geometry/pose_observation.hpp"
#include "fsw/geometry/target_model.hpp"

namespace relnav {

/// Which observations count, by position.
using ObservationMask = std::array<bool, config::max_observations>;

struct PoseSolverSettings {
  double huber_sigma = 0.0;  ///< residual, in sigmas, from which on the loss grows linearly; 0: it is quadratic
  bool switching = true;     ///< of the Rodrigues sets; off only to show what it is for
  int max_iterations = 100;  ///< 4 or 5 as a rule; up to some 30 of a plane seen nearly face on, whose two minima merge
};

/// Maximum-likelihood pose of a target in one or more cameras, started from a pose that lies in its basin (some tens of
/// degrees wide): PoseIteration over pixel residuals, distortion included. At the optimum to 1e-6 sigma; reaches the
/// Cramer-Rao bound (cooperative-mono.md). covariance and chi2 belong to the observations used.
/// ok; invalid_argument: an index outside of the rig or the target, sigma not positive; too_few_features: fewer than 3 used;
/// rank_deficient: they do not determine the pose (collinear, or one point seen often); behind_camera, outside_domain: at
/// the start a feature has no image; no_convergence. `out` is untouched unless ok.
Status solve_pose(const CameraRig& rig, const TargetModel& target, const PoseObservations& observations,
                  const ObservationMask& used, const Pose& start, const PoseSolverSettings& settings,
                  PoseEstimate& out);

/// Chi-square and covariance of a pose that was found otherwise, as if it were the optimum. Errors as solve_pose().
Status assess_pose(const CameraRig& rig, const TargetModel& target, const PoseObservations& observations,
                   const ObservationMask& used, const Pose& pose, PoseEstimate& out);

/// Whitened residual of an observation (observed minus predicted, over sigma). Errors as CameraModel::project().
Status whitened_residual(const CameraRig& rig, const TargetModel& target, const PoseObservation& observation,
                         const Pose& pose, Vec2& residual);

}  // namespace relnav
