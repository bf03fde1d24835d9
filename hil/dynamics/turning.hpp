#pragma once
#include <Eigen/Geometry>
#include <cmath>

#include "fsw/math/types.hpp"
#include "hil/evaluate/rotation.hpp"

namespace relnav::hil {

/// How frame B stands and turns against frame A: dR_AB/dt = [omega_AB_A x] R_AB, rad/s.
struct Turning {
  Mat3 R_AB = Mat3::Identity();
  Vec3 omega_AB_A = Vec3::Zero();
};

/// A to C by way of B.
[[nodiscard]] inline Turning compose(const Turning& ab, const Turning& bc) {
  return {ab.R_AB * bc.R_AB, ab.omega_AB_A + ab.R_AB * bc.omega_AB_A};
}

[[nodiscard]] inline Turning inverse(const Turning& ab) {
  const Mat3 R_BA = ab.R_AB.transpose();
  return {R_BA, -R_BA * ab.omega_AB_A};
}

/// J with d/dt Exp(phi) = [J dphi/dt x] Exp(phi) (Sola, Deray, Atchuthan, A micro Lie theory, 2018, eq. 145).
[[nodiscard]] inline Mat3 left_jacobian(const Vec3& phi) {
  const double angle2 = phi.squaredNorm();
  const double angle = std::sqrt(angle2);
  const Mat3 X = cross_matrix(phi);
  if (angle < 1e-4) return Mat3::Identity() + 0.5 * X + X * X / 6.0;
  return Mat3::Identity() + (1.0 - std::cos(angle)) / angle2 * X + (angle - std::sin(angle)) / (angle2 * angle) * X * X;
}

/// Its inverse, |phi| < 2 pi (the same, eq. 146, by the half angle).
[[nodiscard]] inline Mat3 inverse_left_jacobian(const Vec3& phi) {
  const double angle = phi.norm();
  const Mat3 X = cross_matrix(phi);
  if (angle < 1e-4) return Mat3::Identity() - 0.5 * X + X * X / 12.0;
  return Mat3::Identity() - 0.5 * X + (1.0 / (angle * angle) - 0.5 / (angle * std::tan(0.5 * angle))) * X * X;
}

/// Exp(phi) as a frame that turns.
[[nodiscard]] inline Turning turning_exp(const Vec3& phi, const Vec3& phi_rate) {
  return {rotation_exp(phi), left_jacobian(phi) * phi_rate};
}

/// The shortest turn from frame A to frame B, of which `share` is done, growing at `share_rate`; both are given against
/// a common frame, and so is the result.
[[nodiscard]] inline Turning blend(const Turning& a, const Turning& b, double share, double share_rate) {
  const Turning ab = compose(inverse(a), b);
  const Vec3 phi = rotation_vector(ab.R_AB);
  const Vec3 phi_rate = inverse_left_jacobian(phi) * ab.omega_AB_A;
  return compose(a, turning_exp(share * phi, share_rate * phi + share * phi_rate));
}

/// Roll, pitch, yaw in degrees: Rz(c) Ry(b) Rx(a).
[[nodiscard]] inline Mat3 rotation_of_angles(const Vec3& abc_deg) {
  const Vec3 abc = abc_deg / degrees_per_radian;
  return (Eigen::AngleAxisd(abc.z(), Vec3::UnitZ()) * Eigen::AngleAxisd(abc.y(), Vec3::UnitY()) *
          Eigen::AngleAxisd(abc.x(), Vec3::UnitX()))
      .toRotationMatrix();
}

}  // namespace relnav::hil
