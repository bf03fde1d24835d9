#pragma once
#include <array>
#include <cmath>

#include "fsw/estimation/pose_least_squares.hpp"
#include "fsw/estimation/spot_field.hpp"

namespace relnav {

using RigSpots = std::array<LightSpots, config::max_cameras>;

struct SpotSearchSettings {
  int max_hypotheses = 2600;            ///< work of a call, in three-point problems
  double gate_px = 5.0;                 ///< around a marker predicted from three spots
  double gate_sigma = 4.0;              ///< around a marker predicted from all of them
  double model_sigma_px = 0.2;          ///< 1 sigma of what the spots' own sigma leaves out; added in square
  double range_min_m = 1.0;             ///< of the origin of T
  double range_max_m = 100.0;           ///<
  double max_false_alarms = 1e-4;       ///< expected number of equally good poses by chance that is still believed
  double max_false_alarms_whole = 1.0;  ///< the same if every visible marker has a spot and every spot a marker
  double chi2_factor = 1.5;             ///< over the 99 % point up to which the residuals are believed
  double spot_worth = 20.0;             ///< chi-square that one more explained spot outweighs
  double missing_cost = 8.0;            ///< chi-square that one marker without its spot costs
  double ambiguous_chi2 = 20.0;         ///< another pose that costs less than this more is not excluded
  PoseSolverSettings solver;

  /// invalid_argument: outside of the domain.
  [[nodiscard]] Status check() const {
    const bool valid = max_hypotheses > 0 && gate_px > 0.0 && gate_sigma > 0.0 && model_sigma_px > 0.0 &&
                       range_min_m > 0.0 && range_max_m > range_min_m && std::isfinite(range_max_m);
    return valid ? Status::ok : Status::invalid_argument;
  }
};

/// What is known of the attitude beforehand, e.g. the previous pose.
struct AttitudePrior {
  bool given = false;
  Mat3 R_CT = Mat3::Identity();
  double cone_rad = 3.2;  ///< largest angle of the rotation from it, up to pi
};

/// Everything a hypothesis is held against.
struct SpotScene {
  const CameraRig& rig;
  const TargetModel& target;
  const RigSpots& spots;
  const std::array<SpotField, config::max_cameras>& fields;
  const SpotSearchSettings& settings;
  const AttitudePrior& prior;
  double least_trace;  ///< of the rotation between attitude and prior
};

/// The pose of T in camera k of the rig.
[[nodiscard]] inline Pose in_camera(const RigCamera& camera, const Pose& pose) {
  return {camera.R_KC * pose.R_CT, camera.R_KC * pose.t_CT + camera.t_KC};
}
/// And back: from the pose of T in camera k to that in C0.
[[nodiscard]] inline Pose from_camera(const RigCamera& camera, const Pose& pose) {
  return {camera.R_KC.transpose() * pose.R_CT, camera.R_KC.transpose() * (pose.t_CT - camera.t_KC)};
}
/// Where a camera stands in T, from the pose of T in it.
[[nodiscard]] inline Vec3 camera_centre_T(const Pose& pose) { return -(pose.R_CT.transpose() * pose.t_CT); }

/// Whether the face of a marker can be seen from a point, at an angle off its normal with at least this cosine.
[[nodiscard]] inline bool faces(const TargetFeature& f, const Vec3& centre_T, double least_cosine) {
  const Vec3 away_T = centre_T - f.p_T;
  const double along = f.normal_T.dot(away_T);
  if (!(f.normal_T.squaredNorm() > 0.0)) return true;
  return along > 0.0 && along * along >= least_cosine * least_cosine * away_T.squaredNorm();
}

/// Range and prior attitude allow the pose.
[[nodiscard]] inline bool is_allowed(const SpotScene& scene, const Pose& pose) {
  const double range2 = pose.t_CT.squaredNorm();
  const SpotSearchSettings& s = scene.settings;
  if (!(range2 >= s.range_min_m * s.range_min_m && range2 <= s.range_max_m * s.range_max_m)) return false;
  return !scene.prior.given || scene.prior.R_CT.cwiseProduct(pose.R_CT).sum() >= scene.least_trace;
}

}  // namespace relnav
