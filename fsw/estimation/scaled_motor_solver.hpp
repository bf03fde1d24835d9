#pragma once
#include <algorithm>

#include "fsw/estimation/motor_solver.hpp"

namespace relnav {

/// Triangulation and motor in any scalar, scaled for Q16.47: images normalised and undistorted (in double, beforehand),
/// triangulated in units of the baseline; then lengths over the target's size, positions from the first point seen, so that
/// they are a few sizes whatever the range. Moments about a moved origin leave the least-squares solution as it is.
/// Good up to a range of some 20,000 baselines, beyond what triangulation is worth.
/// Errors as triangulate_features() and solve_motor(); not_finite: a number left its range. `out` is untouched unless ok.
template <typename S>
Status solve_scaled_motor(const CameraRig& rig, const TargetModel& target, const PoseObservations& observations,
                          MotorLines lines, Pose& out) {
  if (rig.size() != 2) return Status::invalid_argument;
  double size = 0.0;
  for (const TargetFeature& feature : target.features) size = std::max(size, feature.p_T.norm());
  const double baseline = rig[1].t_KC.norm();
  if (!(size > 0.0) || !(baseline > 0.0)) return Status::rank_deficient;

  StereoPointsIn<S> points;
  Status status = triangulate_features<S>(rig, target, observations, size, baseline, points);
  if (status != Status::ok) return status;
  if (points.p_C.empty()) return Status::too_few_features;
  const Eigen::Matrix<S, 3, 1> origin = points.p_C[0];
  const auto baseline_per_size = static_cast<S>(baseline / size);
  for (Eigen::Matrix<S, 3, 1>& p : points.p_C) {
    for (int k = 0; k < 3; ++k) p(k) = (p(k) - origin(k)) * baseline_per_size;
  }
  Eigen::Matrix<S, 3, 3> R_CT;
  Eigen::Matrix<S, 3, 1> t;
  status = solve_motor<S>(target, points, lines, R_CT, t);
  if (status != Status::ok) return status;
  if (!is_sound(R_CT) || !is_sound(t)) return Status::not_finite;
  out = {R_CT.template cast<double>(), baseline * origin.template cast<double>() + size * t.template cast<double>()};
  return Status::ok;
}

}  // namespace relnav
