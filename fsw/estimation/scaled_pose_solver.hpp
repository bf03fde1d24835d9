#pragma once
#include <algorithm>
#include <array>
#include <cmath>

#include "fsw/attitude/quaternion.hpp"
#include "fsw/attitude/rodrigues.hpp"
#include "fsw/estimation/pose_iteration.hpp"
#include "fsw/estimation/pose_least_squares.hpp"
#include "fsw/estimation/scalar_traits.hpp"

namespace relnav {

/// Rows of PoseIteration in any scalar, scaled for Q16.47: lengths over the target's size (|X_T| <= 1, so that attitude and
/// position have slopes alike), images normalised and undistorted (in double, beforehand) and weighted with the slope of the
/// pixel there over its sigma, and all rows times a factor by which the normal equations fill the range but stay inside of
/// it, at half the start's depth too. Good up to a range of some 500 times the target's size.
template <typename S>
class ScaledRows {
 public:
  using Vector = Eigen::Matrix<S, 3, 1>;
  using Matrix = Eigen::Matrix<S, 3, 3>;

  /// invalid_argument: an index outside, sigma not positive, a start that is not finite; rank_deficient: all features in T's
  /// origin; behind_camera, outside_domain: a feature has no image.
  Status gather(const CameraRig& rig, const TargetModel& target, const PoseObservations& observations,
                const ObservationMask& used, const Pose& start) {
    double largest_weight = 0.0;
    double largest_image = 0.0;
    double start_cost = 0.0;
    double least_depth = 0.0;
    std::array<Vec2, config::max_observations> images;
    std::array<Mat2, config::max_observations> weights;
    for (std::size_t i = 0; i < observations.size(); ++i) {
      if (!used[i]) continue;
      const PoseObservation& o = observations[i];
      if (o.camera >= rig.size() || o.feature >= target.features.size() || !(o.sigma_px > 0.0)) {
        return Status::invalid_argument;
      }
      const RigCamera& camera = rig[o.camera];
      const Vec3& p_T = target.features[o.feature].p_T;
      Vec3 ray;
      const Status status = camera.model.unproject(o.uv_px, ray);
      if (status != Status::ok) return status;
      if (!(ray.z() > 0.0)) return Status::outside_domain;
      images[i] = ray.head<2>() / ray.z();
      Vec2 uv_px;
      Mat23 J_uv_p;
      const Status projected = camera.model.project(Vec3(ray / ray.z()), uv_px, J_uv_p);
      if (projected != Status::ok) return projected;
      weights[i] = J_uv_p.leftCols<2>() / o.sigma_px;
      const Vec3 p_K = camera.R_KC * (start.R_CT * p_T + start.t_CT) + camera.t_KC;
      const double depth = p_K.z();
      if (!p_K.allFinite()) return Status::invalid_argument;
      if (!(depth > 0.0)) return Status::behind_camera;
      const bool first = count_ == 0;
      least_depth = first ? depth : std::min(least_depth, depth);
      largest_weight = std::max(largest_weight, weights[i].norm());
      largest_image = std::max(largest_image, images[i].norm());
      start_cost += (images[i] - p_K.head<2>() / depth).squaredNorm();
      length_ = std::max(length_, p_T.norm());
      ++count_;
    }
    if (count_ == 0) return Status::too_few_features;
    if (!(length_ > 0.0)) return Status::rank_deficient;
    // With rows of weight 1 over the largest, an observation adds at most |J|^2 to the diagonal, |J| = sqrt(1 + image^2) /
    // depth. The cost is largest at the start.
    const double n = count_;
    const double slope = std::sqrt(n * (1.0 + largest_image * largest_image)) * length_ / least_depth;
    const double factor = std::min(largest_root / slope, largest_root / std::sqrt(start_cost));
    sigma_ = factor / largest_weight;

    for (std::size_t k = 0; k < rig.size(); ++k) {
      R_KC_[k] = rig[k].R_KC.template cast<S>();
      t_KC_[k] = Vec3(rig[k].t_KC / length_).template cast<S>();
    }
    int at = 0;
    for (std::size_t i = 0; i < observations.size(); ++i) {
      if (!used[i]) continue;
      const PoseObservation& o = observations[i];
      Row& row = rows_[static_cast<std::size_t>(at++)];
      row.X_T = Vec3(target.features[o.feature].p_T / length_).template cast<S>();
      row.xy = images[i].template cast<S>();
      row.weight = Mat2(sigma_ * weights[i]).template cast<S>();
      row.camera = o.camera;
    }
    return Status::ok;
  }

  Status operator()(int i, const Matrix& R_CT, const Vector& t_CT, PoseRow<S>& out) const {
    const Row& row = rows_[static_cast<std::size_t>(i)];
    const Matrix& R = R_KC_[row.camera];
    out.X_r = turned(R_CT, row.X_T);
    const Vector p_K = sum(turned(R, sum(out.X_r, t_CT)), t_KC_[row.camera]);
    if (!(p_K(2) > S(least_depth_per_size))) return Status::behind_camera;
    const S inverse = S(1) / p_K(2);
    const S x = p_K(0) * inverse, y = p_K(1) * inverse;
    const S dx = row.xy(0) - x, dy = row.xy(1) - y;
    for (int k = 0; k < 3; ++k) out.axis(k) = R(2, k);
    out.depth = p_K(2);
    for (int k = 0; k < 2; ++k) {
      const S a = row.weight(k, 0), b = row.weight(k, 1);
      out.r(k) = a * dx + b * dy;
      const S a_z = a * inverse, b_z = b * inverse;
      for (int c = 0; c < 3; ++c) out.J(k, c) = a_z * (R(0, c) - x * R(2, c)) + b_z * (R(1, c) - y * R(2, c));
    }
    return Status::ok;
  }

  [[nodiscard]] int count() const { return count_; }
  /// m; the unit of lengths.
  [[nodiscard]] double length() const { return length_; }
  /// Of each row's residual.
  [[nodiscard]] double sigma() const { return sigma_; }

 private:
  struct Row {
    Vector X_T;
    Eigen::Matrix<S, 2, 1> xy;
    Eigen::Matrix<S, 2, 2> weight;
    std::size_t camera;
  };
  static constexpr double largest_root = 64.0;  ///< of the diagonal and of the cost: a sixteenth of the range
  static constexpr double least_depth_per_size = 1e-3;

  [[nodiscard]] static Vector turned(const Matrix& R, const Vector& v) {
    Vector w;
    for (int k = 0; k < 3; ++k) w(k) = R(k, 0) * v(0) + R(k, 1) * v(1) + R(k, 2) * v(2);
    return w;
  }
  [[nodiscard]] static Vector sum(const Vector& a, const Vector& b) {
    return Vector(a(0) + b(0), a(1) + b(1), a(2) + b(2));
  }

  std::array<Row, config::max_observations> rows_;
  std::array<Matrix, config::max_cameras> R_KC_;
  std::array<Vector, config::max_cameras> t_KC_;
  double length_ = 0.0;
  double sigma_ = 0.0;
  int count_ = 0;
};

/// PoseIteration in any scalar. The cost differs from that of solve_pose() by how distortion bends within a residual.
/// Chi-square and covariance are those of the result, in double. huber_sigma is not looked at.
/// Errors as solve_pose(); not_finite: a number left its range. With switching off that is g near 180 deg: in Q16.47 g'g does
/// from |g| = 256 on, 0.45 deg away; in floating point at 180 deg itself.
template <typename S>
Status solve_scaled_pose(const CameraRig& rig, const TargetModel& target, const PoseObservations& observations,
                         const ObservationMask& used, const Pose& start, const PoseSolverSettings& settings,
                         PoseEstimate& out) {
  using Traits = ScalarTraits<S>;
  ScaledRows<S> rows;
  Status status = rows.gather(rig, target, observations, used, start);
  if (status != Status::ok) return status;

  PoseIteration<S> iteration;
  if (settings.switching) {
    const RodriguesChart chart = RodriguesChart::from_dcm(start.R_CT);
    iteration.attitude = {chart.parameters().template cast<S>(), chart.set_index()};
  } else {
    const Quaternion q = Quaternion::from_dcm(start.R_CT);
    iteration.attitude = {Vec3(-q.vector() / q.w).cast<S>(), 0};
  }
  iteration.t = Vec3(start.t_CT / rows.length()).cast<S>();
  IterationLimits<S> limits;
  limits.max_iterations = settings.max_iterations;
  limits.gain = S(std::max(Traits::gain * rows.sigma() * rows.sigma(), Traits::least_gain));
  limits.least_rate = S(Traits::least_rate);
  limits.step = S(Traits::step);
  limits.cost_slack = S(Traits::cost_slack);
  limits.least_pivot = S(Traits::least_pivot);
  limits.switching = settings.switching;
  status = iteration.solve(rows.count(), rows, limits);
  // Whatever it says: with numbers that have left their range it means nothing.
  if (!is_sound(iteration.t) || !is_sound(iteration.attitude.dcm())) return Status::not_finite;
  if (status != Status::ok) return status;

  const RodriguesChart chart =
      RodriguesChart::from_parameters(iteration.attitude.g.template cast<double>(), iteration.attitude.set);
  const Pose pose{chart.dcm(), rows.length() * iteration.t.template cast<double>()};
  const Status assessed = assess_pose(rig, target, observations, used, pose, out);
  out.iterations = iteration.iterations();
  return assessed;
}

}  // namespace relnav
