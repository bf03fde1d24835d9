#pragma once
#include "fsw/math/types.hpp"

namespace relnav {

/// Hamilton quaternion v + w, v = (x, y, z), of an active rotation R (with R = R_CT: that of p_C = R_CT p_T).
/// R(a b) = R(a) R(b); q and -q are the same rotation. Source: Sola, "Quaternion kinematics for the error-state Kalman
/// filter", arXiv:1711.02508, sections 1.2 (product), 2.4 (exponential, logarithm) and 2.5 (matrix).
struct Quaternion {
  double x = 0.0;
  double y = 0.0;
  double z = 0.0;
  double w = 1.0;

  [[nodiscard]] static Quaternion from_parts(const Vec3& v, double w) { return {v.x(), v.y(), v.z(), w}; }

  /// Unit, w >= 0. R orthonormal to about 1e-3 (the result is normalised). Pivots on the largest of the four components
  /// (Shepperd, J. Guidance and Control 1(3), 1978), hence full precision at every angle, 180 deg included.
  [[nodiscard]] static Quaternion from_dcm(const Mat3& R);

  /// (sin(|phi|/2) phi/|phi|, cos(|phi|/2)): unit; |phi| (rad) up to math::max_angle, NaN beyond. Continuous in phi, so
  /// w < 0 for |phi| beyond pi.
  [[nodiscard]] static Quaternion from_rotation_vector(const Vec3& phi);

  [[nodiscard]] Vec3 vector() const { return {x, y, z}; }
  [[nodiscard]] double squared_norm() const { return x * x + y * y + z * z + w * w; }
  [[nodiscard]] Quaternion conjugate() const { return {-x, -y, -z, w}; }

  /// Unit length, same sign. Needs a norm within 1e-150 .. 1e150.
  [[nodiscard]] Quaternion normalised() const;

  /// Of q and -q the one with w >= 0, as interfaces, files and packets have it.
  [[nodiscard]] Quaternion canonical() const { return w < 0.0 ? Quaternion{-x, -y, -z, -w} : *this; }

  /// R = (w^2 - v'v) I + 2 v v' + 2 w [v x], for a quaternion of unit norm to rounding.
  [[nodiscard]] Mat3 dcm() const;

  /// phi = 2 atan2(|v|, w) v/|v| with |phi| <= pi, for a unit quaternion of either sign.
  [[nodiscard]] Vec3 rotation_vector() const;
};

/// Hamilton product a b: rotate by b first, then by a.
[[nodiscard]] Quaternion multiply(const Quaternion& a, const Quaternion& b);

}  // namespace relnav
