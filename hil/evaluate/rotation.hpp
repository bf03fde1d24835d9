#pragma once
#include <Eigen/Geometry>
#include <cmath>

#include "fsw/math/types.hpp"

namespace relnav::hil {

inline constexpr double degrees_per_radian = 57.295779513082320876798154814105;

/// Matrix of the cross product: cross_matrix(a) b = a x b.
[[nodiscard]] inline Mat3 cross_matrix(const Vec3& a) {
  Mat3 m;
  m << 0.0, -a.z(), a.y(), a.z(), 0.0, -a.x(), -a.y(), a.x(), 0.0;
  return m;
}

/// Rotation vector phi (rad, length 0..pi) with R = Exp([phi x]).
[[nodiscard]] inline Vec3 rotation_vector(const Mat3& R) {
  Eigen::Quaterniond q(R);
  if (q.w() < 0.0) q.coeffs() = -q.coeffs();
  const double half_sine = q.vec().norm();
  if (half_sine < 1e-12) return 2.0 * q.vec();
  return (2.0 * std::atan2(half_sine, q.w()) / half_sine) * q.vec();
}

[[nodiscard]] inline Mat3 rotation_exp(const Vec3& phi) {
  const double angle = phi.norm();
  if (angle < 1e-300) return Mat3::Identity();
  return Eigen::AngleAxisd(angle, Vec3(phi / angle)).toRotationMatrix();
}

}  // namespace relnav::hil
