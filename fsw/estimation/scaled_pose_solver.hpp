#pragma once
#include <array>
#include <cmath>

#include "fsw/attitude/quaternion.hpp"
#include "fsw/attitude/rodrigues.hpp"
#include "fsw/estimation/pose_iteration.hpp"
#include "fsw/estimation/pose_least_squares.hpp"
#include "fsw/math/fixed.hpp"

namespace relnav {

/// What an iteration in a scalar narrower than double needs to know of it.
template <typename S>
struct ScalarTraits;

template <>
struct ScalarTraits<double> {
  static constexpr double step = 1e-13;
  static constexpr double cost_slack = 1e-12;
  static constexpr double least_pivot = 1e-13;
  static bool is_sound(double value) { return std::isfinite(value); }
};
template <>
struct ScalarTraits<float> {
  static constexpr double step = 2e-6;
  static constexpr double cost_slack = 1e-5;
  static constexpr double least_pivot = 2e-7;
  static bool is_sound(float value) { return std::isfinite(value); }
};
template <int FractionBits>
struct ScalarTraits<Fixed<FractionBits>> {
  static constexpr double step = 1e-11;
  static constexpr double cost_slack = 1e-10;
  static constexpr double least_pivot = 1e-11;
  static bool is_sound(const Fixed<FractionBits>& value) { return !value.overflowed(); }
};

/// PoseIteration in any scalar, scaled so that nothing leaves the range of Q16.47: lengths over the start's distance, images
/// normalised and undistorted (in double, beforehand), weights over the largest. The cost differs from that of solve_pose()
/// by what distortion bends within a residual. Chi-square and covariance are those of the result, in double.
/// Errors as solve_pose(); not_finite: overflow on the way.
template <typename S>
Status solve_scaled_pose(const CameraRig& rig, const TargetModel& target, const PoseObservations& observations,
                         const ObservationMask& used, const Pose& start, const PoseSolverSettings& settings,
                         PoseEstimate& out) {
  using Traits = ScalarTraits<S>;
  using Vector3 = Eigen::Matrix<S, 3, 1>;
  struct Row {
    Vector3 X_T;
    Eigen::Matrix<S, 2, 1> xy;
    S weight;
    std::size_t camera;
  };
  const double length = start.t_CT.norm();
  if (!(length > 0.0) || !std::isfinite(length)) return Status::invalid_argument;

  std::array<Row, config::max_observations> rows;
  std::array<Eigen::Matrix<S, 3, 3>, config::max_cameras> R_KC;
  std::array<Vector3, config::max_cameras> t_KC;
  for (std::size_t k = 0; k < rig.size(); ++k) {
    R_KC[k] = rig[k].R_KC.cast<S>();
    t_KC[k] = Vec3(rig[k].t_KC / length).cast<S>();
  }
  double least_sigma = 0.0;
  for (std::size_t i = 0; i < observations.size(); ++i) {
    const double sigma = observations[i].sigma_px;
    if (used[i] && (!(least_sigma > 0.0) || sigma < least_sigma)) least_sigma = sigma;
  }
  int count = 0;
  for (std::size_t i = 0; i < observations.size(); ++i) {
    const PoseObservation& o = observations[i];
    if (!used[i]) continue;
    if (o.camera >= rig.size() || o.feature >= target.features.size() || !(o.sigma_px > 0.0)) {
      return Status::invalid_argument;
    }
    Vec3 ray;
    const Status status = rig[o.camera].model.unproject(o.uv_px, ray);
    if (status != Status::ok) return status;
    if (!(ray.z() > 0.0)) return Status::outside_domain;
    Row& row = rows[static_cast<std::size_t>(count++)];
    row.X_T = Vec3(target.features[o.feature].p_T / length).cast<S>();
    row.xy = Vec2(ray.head<2>() / ray.z()).cast<S>();
    row.weight = S(least_sigma / o.sigma_px);
    row.camera = o.camera;
  }

  PoseIteration<S> iteration;
  if (settings.switching) {
    const RodriguesChart chart = RodriguesChart::from_dcm(start.R_CT);
    iteration.attitude = {chart.parameters().template cast<S>(), chart.set_index()};
  } else {
    const Quaternion q = Quaternion::from_dcm(start.R_CT);
    iteration.attitude = {Vec3(-q.vector() / q.w).cast<S>(), 0};
  }
  iteration.t = Vec3(start.t_CT / length).cast<S>();
  const auto row_of = [&](int i, const Eigen::Matrix<S, 3, 3>& R_CT, const Vector3& t_CT, PoseRow<S>& out_row) {
    const Row& row = rows[static_cast<std::size_t>(i)];
    const auto turned = [](const Eigen::Matrix<S, 3, 3>& R, const Vector3& v) {
      Vector3 w;
      for (int k = 0; k < 3; ++k) w(k) = R(k, 0) * v(0) + R(k, 1) * v(1) + R(k, 2) * v(2);
      return w;
    };
    out_row.X_r = turned(R_CT, row.X_T);
    Vector3 p = out_row.X_r;
    for (int k = 0; k < 3; ++k) p(k) += t_CT(k);
    const Eigen::Matrix<S, 3, 3>& R = R_KC[row.camera];
    Vector3 p_K = turned(R, p);
    for (int k = 0; k < 3; ++k) p_K(k) += t_KC[row.camera](k);
    if (!(p_K(2) > S(1e-3))) return Status::behind_camera;
    const S inverse = S(1) / p_K(2);
    for (int k = 0; k < 2; ++k) {
      const S image = p_K(k) * inverse;
      out_row.r(k) = row.weight * (row.xy(k) - image);
      const S scale = row.weight * inverse;
      for (int c = 0; c < 3; ++c) out_row.J(k, c) = scale * (R(k, c) - image * R(2, c));
    }
    return Status::ok;
  };
  IterationLimits<S> limits;
  limits.max_iterations = settings.max_iterations;
  limits.gain = S(0);
  limits.step = S(Traits::step);
  limits.cost_slack = S(Traits::cost_slack);
  limits.least_pivot = S(Traits::least_pivot);
  limits.switching = settings.switching;
  const Status status = iteration.solve(count, row_of, limits);
  if (status != Status::ok) return status;
  bool sound = true;
  for (int k = 0; k < 3; ++k)
    sound = sound && Traits::is_sound(iteration.attitude.g(k)) && Traits::is_sound(iteration.t(k));
  if (!sound) return Status::not_finite;

  const RodriguesChart chart =
      RodriguesChart::from_parameters(iteration.attitude.g.template cast<double>(), iteration.attitude.set);
  const Pose pose{chart.dcm(), length * iteration.t.template cast<double>()};
  const Status assessed = assess_pose(rig, target, observations, used, pose, out);
  out.iterations = iteration.iterations();
  return assessed;
}

}  // namespace relnav
