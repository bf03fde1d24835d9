#include "fsw/estimation/cooperative_estimator.hpp"

#include <algorithm>

#include "fsw/attitude/quaternion.hpp"
#include "fsw/estimation/closed_form_covariance.hpp"

namespace relnav {
namespace {

double angle_between(const Pose& a, const Pose& b) {
  return Quaternion::from_dcm(a.R_CT * b.R_CT.transpose()).rotation_vector().norm();
}

}  // namespace

Status CooperativeEstimator::configure(const CooperativeConfig& config, const CameraRig& rig,
                                       const TargetModel& target) {
  const bool closed_form = config.method != CooperativeMethod::least_squares;
  if (rig.empty() || target.features.size() < 3 || (closed_form && rig.size() != 2)) return Status::invalid_argument;
  config_ = config;
  rig_ = rig;
  target_ = target;
  return Status::ok;
}

bool CooperativeEstimator::is_one_camera(const PoseObservations& observations) const {
  for (const PoseObservation& o : observations) {
    if (o.camera != observations[0].camera) return false;
  }
  return true;
}

Status CooperativeEstimator::solve_closed_form(const PoseObservations& observations, CooperativeSolution& out) const {
  StereoPoints points;
  Status status = triangulate_features(rig_, target_, observations, points);
  if (status != Status::ok) return status;
  const auto solve = [this](const StereoPoints& at, Pose& pose) {
    return config_.method == CooperativeMethod::motor ? solve_motor(target_, at, config_.lines, pose)
                                                      : solve_orthogonal(at, pose);
  };
  Pose pose;
  status = solve(points, pose);
  if (status == Status::ok) status = assess_pose(rig_, target_, observations, out.used, pose, out.estimate);
  if (status != Status::ok) return status;
  // Residuals of a closed form are larger than the pixels' noise; whether the pixels fit together is seen at the optimum.
  PoseEstimate optimum;
  status = solve_pose(rig_, target_, observations, out.used, pose, config_.acquisition.solver, optimum);
  if (status == Status::ok && is_alarming(optimum, config_.outliers)) status = Status::inconsistent;
  if (status != Status::ok) return status;
  return propagate_pixel_noise(rig_, observations, points, solve, out.estimate.covariance);
}

Status CooperativeEstimator::find_minimum(const PoseObservations& observations, const Pose* prior,
                                          CooperativeSolution& out) const {
  const PoseSolverSettings& solver = config_.acquisition.solver;
  Status status = Status::no_convergence;
  out.acquired = false;
  if (prior != nullptr) {
    status = solve_pose(rig_, target_, observations, out.used, *prior, solver, out.estimate);
    if (status == Status::ok && !is_alarming(out.estimate, config_.outliers)) return status;
  }
  PoseEstimate fresh;
  Status triangulated = Status::ok;
  if (rig_.size() == 2) {
    StereoPoints points;
    Pose pose;
    triangulated = triangulate_features(rig_, target_, observations, points);
    if (triangulated == Status::ok && solve_motor(target_, points, MotorLines::all, pose) == Status::ok &&
        solve_pose(rig_, target_, observations, out.used, pose, solver, fresh) == Status::ok &&
        (status != Status::ok || fresh.chi2 < out.estimate.chi2)) {
      out.estimate = fresh;
      out.acquired = true;
      status = Status::ok;
      if (!is_alarming(fresh, config_.outliers)) return status;
    }
  }
  AcquiredPose acquired;
  const Status fresh_status = acquire_pose(rig_, target_, observations, out.used, config_.acquisition, acquired);
  if (fresh_status == Status::ok && (status != Status::ok || acquired.best.chi2 < out.estimate.chi2)) {
    out.estimate = acquired.best;
    out.acquired = true;
    return Status::ok;
  }
  if (status == Status::ok) return status;
  // No pose at all, and the cameras do not look at the same thing: that is why.
  return triangulated == Status::inconsistent ? triangulated : fresh_status;
}

Status CooperativeEstimator::weigh_minima(const PoseObservations& observations, const Pose* prior,
                                          CooperativeSolution& out) const {
  AcquiredPose acquired;
  if (acquire_pose(rig_, target_, observations, out.used, config_.acquisition, acquired) != Status::ok) {
    return Status::ok;  // fewer features than that takes: what was found from the prior stands
  }
  if (acquired.best.chi2 < out.estimate.chi2) {
    out.estimate = acquired.best;
  }
  if (!acquired.ambiguous) return Status::ok;
  out.other = acquired.other;
  if (prior == nullptr) return Status::ambiguous;
  const double best = angle_between(out.estimate.pose, *prior);
  const double other = angle_between(out.other.pose, *prior);
  if (std::min(best, other) > config_.prior_cone_rad || std::max(best, other) < 2.0 * std::min(best, other)) {
    return Status::ambiguous;
  }
  if (other < best) std::swap(out.estimate, out.other);
  return Status::ok;
}

Status CooperativeEstimator::solve(const PoseObservations& observations, const Pose* prior,
                                   CooperativeSolution& out) const {
  out.used.fill(false);
  for (std::size_t i = 0; i < observations.size(); ++i) out.used[i] = true;
  if (config_.method != CooperativeMethod::least_squares) return solve_closed_form(observations, out);
  Status status = find_minimum(observations, prior, out);
  if (status != Status::ok) return status;
  if (is_alarming(out.estimate, config_.outliers)) {
    status = reject_outliers(rig_, target_, observations, out.estimate.pose, config_.acquisition, config_.outliers,
                             out.used, out.estimate);
    if (status != Status::ok) return Status::inconsistent;
  }
  return is_one_camera(observations) ? weigh_minima(observations, prior, out) : Status::ok;
}

}  // namespace relnav
