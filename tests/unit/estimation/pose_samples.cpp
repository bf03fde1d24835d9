#include "tests/unit/estimation/pose_samples.hpp"

#include <cmath>
#include <cstdlib>
#include <limits>

#include "tests/support/dense.hpp"

namespace relnav::test {

CameraModel camera_of(const CameraIntrinsics& k) {
  const Expected<CameraModel> camera = CameraModel::create(k);
  if (!camera) std::abort();
  return camera.value();
}

CameraIntrinsics pinhole() {
  CameraIntrinsics k;
  k.fu = 1000.0;
  k.fv = 1005.0;
  k.cu = 510.0;
  k.cv = 520.0;
  k.width_px = 1024;
  k.height_px = 1024;
  return k;
}

CameraIntrinsics long_focus() {
  CameraIntrinsics k;
  k.fu = k.fv = 200.0 / 0.007;
  k.cu = k.cv = 1023.5;
  k.width_px = k.height_px = 2048;
  return k;
}

CameraIntrinsics stereo_paper_camera() {
  CameraIntrinsics k;
  k.fu = 35.0 * 4256.0 / 36.0;
  k.fv = 35.0 * 2832.0 / 23.9;
  k.cu = 2127.5;
  k.cv = 1415.5;
  k.width_px = 4256;
  k.height_px = 2832;
  return k;
}

CameraIntrinsics distorted(DistortionModel model) {
  CameraIntrinsics k = pinhole();
  k.model = model;
  switch (model) {
    case DistortionModel::none: break;
    case DistortionModel::radial_tangential: k.coefficients = {-0.2, 0.05, 1e-3, -5e-4}; break;
    case DistortionModel::radial_inverse: k.coefficients = {0.1, 0.02, 0.0, 0.0}; break;
    case DistortionModel::equidistant: k.coefficients = {0.02, -0.01, 0.002, 0.0}; break;
  }
  return k;
}

CameraRig mono_rig(const CameraIntrinsics& k) {
  CameraRig rig;
  if (rig.push_back({camera_of(k), Mat3::Identity(), Vec3::Zero()}) != Status::ok) std::abort();
  return rig;
}

CameraRig stereo_rig(const CameraIntrinsics& k0, const CameraIntrinsics& k1, const Mat3& R_10, const Vec3& p_C0) {
  CameraRig rig = mono_rig(k0);
  if (rig.push_back({camera_of(k1), R_10, Vec3(-(R_10 * p_C0))}) != Status::ok) std::abort();
  return rig;
}

TargetModel target_of(const std::vector<Vec3>& points) {
  TargetModel target;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (target.features.push_back({static_cast<std::uint16_t>(i), points[i], Vec3::Zero()}) != Status::ok) std::abort();
  }
  return target;
}

std::vector<Vec3> cube(double half_width) {
  std::vector<Vec3> points;
  for (int i = 0; i < 8; ++i) {
    points.emplace_back((i & 1) != 0 ? half_width : -half_width, (i & 2) != 0 ? half_width : -half_width,
                        (i & 4) != 0 ? half_width : -half_width);
  }
  return points;
}

std::vector<Vec3> square(double half_diagonal, const Vec3& middle) {
  return {middle + Vec3(-half_diagonal, 0, 0), middle + Vec3(0, -half_diagonal, 0), middle + Vec3(half_diagonal, 0, 0),
          middle + Vec3(0, half_diagonal, 0)};
}

Mat3 random_attitude(Normal& rng) {
  Eigen::Vector4d q;
  for (int k = 3; k >= 0; --k) q(k) = rng();
  q.normalize();
  const Vec3 v = q.head<3>();
  const double angle = 2.0 * std::atan2(v.norm(), q(3));
  return reference_dcm(v, angle);
}

Mat3 random_half_turn(Normal& rng) { return reference_dcm(rng.vec3(), pi_l); }

double rotation_angle(const Mat3& A, const Mat3& B) {
  const Mat3 D = A.transpose() * B;
  const Vec3 v(D(2, 1) - D(1, 2), D(0, 2) - D(2, 0), D(1, 0) - D(0, 1));
  return std::atan2(0.5 * v.norm(), 0.5 * (D.trace() - 1.0));
}

Vec6 pose_difference(const Pose& from, const Pose& to) {
  const Mat3 D = to.R_CT * from.R_CT.transpose();
  const Vec3 v(D(2, 1) - D(1, 2), D(0, 2) - D(2, 0), D(1, 0) - D(0, 1));
  const double sine = 0.5 * v.norm();
  const double angle = std::atan2(sine, 0.5 * (D.trace() - 1.0));
  Vec6 d;
  d << to.t_CT - from.t_CT, v * (sine > 1e-12 ? 0.5 * angle / sine : 0.5);
  return d;
}

Pose moved_pose(const Pose& pose, const Vec6& d) {
  const Vec3 phi = d.tail<3>();
  Pose out = pose;
  out.t_CT += d.head<3>();
  if (phi.norm() > 0.0) out.R_CT = reference_dcm(phi, phi.norm()) * pose.R_CT;
  return out;
}

Vec3 in_camera(const CameraRig& rig, std::size_t camera, const Pose& pose, const Vec3& p_T) {
  return rig[camera].R_KC * (pose.R_CT * p_T + pose.t_CT) + rig[camera].t_KC;
}

bool see(const CameraRig& rig, const TargetModel& target, const Pose& pose, std::size_t camera, std::size_t feature,
         double sigma_px, Normal& rng, PoseObservations& out, double noise_factor) {
  Vec2 uv_px;
  if (rig[camera].model.project(in_camera(rig, camera, pose, target.features[feature].p_T), uv_px) != Status::ok) {
    return false;
  }
  const double nu = rng();
  const double nv = rng();
  PoseObservation o;
  o.feature = static_cast<std::uint16_t>(feature);
  o.camera = static_cast<std::uint16_t>(camera);
  o.uv_px = uv_px + noise_factor * sigma_px * Vec2(nu, nv);
  o.sigma_px = sigma_px;
  return out.push_back(o) == Status::ok;
}

PoseObservations see_all(const CameraRig& rig, const TargetModel& target, const Pose& pose, double sigma_px,
                         Normal& rng, double noise_factor) {
  PoseObservations out;
  for (std::size_t c = 0; c < rig.size(); ++c) {
    for (std::size_t f = 0; f < target.features.size(); ++f) {
      if (!see(rig, target, pose, c, f, sigma_px, rng, out, noise_factor)) std::abort();
    }
  }
  return out;
}

ObservationMask all_used() {
  ObservationMask used;
  used.fill(true);
  return used;
}

Eigen::VectorXd residuals(const CameraRig& rig, const TargetModel& target, const PoseObservations& observations,
                          const Pose& pose) {
  Eigen::VectorXd r(2 * static_cast<Eigen::Index>(observations.size()));
  for (std::size_t i = 0; i < observations.size(); ++i) {
    const PoseObservation& o = observations[i];
    Vec2 uv_px = Vec2::Constant(std::numeric_limits<double>::quiet_NaN());
    static_cast<void>(
        rig[o.camera].model.project(in_camera(rig, o.camera, pose, target.features[o.feature].p_T), uv_px));
    r.segment<2>(2 * static_cast<Eigen::Index>(i)) = (o.uv_px - uv_px) / o.sigma_px;
  }
  return r;
}

Eigen::MatrixXd pose_jacobian(const CameraRig& rig, const TargetModel& target, const PoseObservations& observations,
                              const Pose& pose) {
  Eigen::MatrixXd J(2 * static_cast<Eigen::Index>(observations.size()), 6);
  const double range = pose.t_CT.norm();
  for (int k = 0; k < 6; ++k) {
    const double step = k < 3 ? 1e-5 * range : 1e-5;
    Vec6 d = Vec6::Zero();
    d(k) = step;
    J.col(k) = (residuals(rig, target, observations, moved_pose(pose, -d)) -
                residuals(rig, target, observations, moved_pose(pose, d))) /
               (2.0 * step);
  }
  return J;
}

Mat6 pose_bound(const CameraRig& rig, const TargetModel& target, const PoseObservations& observations,
                const Pose& pose) {
  const Eigen::MatrixXd J = pose_jacobian(rig, target, observations, pose);
  return solve_symmetric(J.transpose().lazyProduct(J), Eigen::MatrixXd::Identity(6, 6));
}

Pose reference_optimum(const CameraRig& rig, const TargetModel& target, const PoseObservations& observations,
                       Pose pose) {
  double lambda = 1e-6;
  Eigen::VectorXd r = residuals(rig, target, observations, pose);
  for (int iteration = 0; iteration < 60; ++iteration) {
    const Eigen::MatrixXd J = pose_jacobian(rig, target, observations, pose);
    Eigen::MatrixXd stacked(J.rows() + 6, 6);
    const Vec6 damping = std::sqrt(lambda) * J.colwise().norm().transpose();
    stacked << J, Mat6(damping.asDiagonal());
    Eigen::VectorXd right = Eigen::VectorXd::Zero(J.rows() + 6);
    right.head(J.rows()) = r;
    const Vec6 d = solve_least_squares(stacked, right);
    const Pose next = moved_pose(pose, d);
    const Eigen::VectorXd r_next = residuals(rig, target, observations, next);
    if (r_next.squaredNorm() <= r.squaredNorm() * (1.0 + 1e-13) + 1e-18) {
      pose = next;
      r = r_next;
      lambda *= 0.01;
      if ((J * d).norm() < 1e-9) break;
    } else {
      lambda = 100.0 * lambda + 1e-9;
    }
  }
  return pose;
}

}  // namespace relnav::test
