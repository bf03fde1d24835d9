#pragma once
#include "fsw/attitude/attitude_chart.hpp"
#include "fsw/math/types.hpp"

namespace relnav {

/// Classical Rodrigues parameters (Gibbs vector) with switching between four sets, Shuster's method of sequential
/// rotations (MSR). Members: see AttitudeChart.
/// Source: Yue, Hou, "Vision-based relative position and attitude determination using Rodrigues parameters", J.
/// Astronautics 31(3), 2010, equations (1)-(5), (10), as given in cooperative-mono.md. Shuster's (passive) convention
/// is kept:
///   R_CT = C(g) R^(i),  C(g) = ((1 - g'g) I + 2 g g' - 2 [g x]) / (1 + g'g),
///   R^(0) = I, R^(1) = diag(1,-1,-1), R^(2) = diag(-1,1,-1), R^(3) = diag(-1,-1,1),
/// g = g_CT^(i), i = set_index. The active Hamilton quaternion of C(g) is proportional to (-g, 1); the only places
/// where the conventions meet are from_dcm() and dcm(), and the active rotation vector in rotated() and the error
/// Jacobians.
///
/// Error Jacobian: (10) with a = dg = -dphi/2 gives g + dg + g x dg + g (g'dg), hence
///   A^-1 = -1/2 (I + [g x] + g g'),   A = -2 (I - [g x]) / (1 + g'g),   g_dot = A^-1 omega_C.
///
/// Switching: with j = argmax |g_j|, due when |g_j| > 1; afterwards every |g_k| <= 1, exactly, also in floating point.
/// Within that bound |A| <= 2 and |A^-1| <= 2. Each set is singular at 180 deg from its own reference, |g| -> infinity.
class RodriguesChart {
 public:
  static constexpr int set_count = 4;

  /// The identity, in set 0.
  RodriguesChart() = default;
  /// In the set with the smallest |g|: every |g_k| <= 1.
  [[nodiscard]] static RodriguesChart from_dcm(const Mat3& R_CT);
  [[nodiscard]] static RodriguesChart from_parameters(const Vec3& g_CT, int set_index);

  [[nodiscard]] Mat3 dcm() const;
  [[nodiscard]] const Vec3& parameters() const { return g_CT_; }
  [[nodiscard]] int set_index() const { return set_index_; }
  void add(const Vec3& delta) { g_CT_ += delta; }

  [[nodiscard]] Mat3 error_jacobian() const;
  [[nodiscard]] Mat3 error_jacobian_inverse() const;
  [[nodiscard]] Vec3 kinematics(const Vec3& omega_C) const;
  [[nodiscard]] RodriguesChart rotated(const Vec3& phi_C) const;
  [[nodiscard]] RodriguesChart rotated(const Vec3& phi_C, Mat3& J_new_old, Mat3& J_new_phi) const;

  [[nodiscard]] bool switch_due() const;
  [[nodiscard]] RodriguesChart switched(Mat3& J_new_old) const;
  [[nodiscard]] bool switch_if_due(Mat3& J_new_old);

 private:
  Vec3 g_CT_ = Vec3::Zero();
  int set_index_ = 0;
};

}  // namespace relnav
