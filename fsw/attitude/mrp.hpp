#pragma once
#include "fsw/attitude/attitude_chart.hpp"
#include "fsw/math/types.hpp"

namespace relnav {

/// Modified Rodrigues parameters sigma = v / (1 + w) = n tan(theta/4) of the Hamilton quaternion (v, w) of R_CT, with
/// the shadow set sigma_shadow = -sigma / (sigma'sigma). Members: see AttitudeChart.
/// Source: Schaub, Junkins, "Stereographic orientation parameters for attitude dynamics", J. Astronautical Sciences
/// 44(1), 1996 (definition, shadow set, kinematics): sigma_dot = 1/4 ((1 - s's) I + 2 [s x] + 2 s s') omega,
/// which noncooperative.md (State) repeats. That formula is for the body rate (R' = R [omega x]). Here the rate is
/// expressed in C and acts from the left (R_CT' = [omega_C x] R_CT), which turns the sign of the cross term:
///   sigma_dot = 1/4 ((1 - s's) I - 2 [s x] + 2 s s') omega_C.
/// (The same thing seen from the other side: the paper's parameters and rate are those of C relative to T,
/// s_paper = -sigma and omega_paper = -omega_C; put in, the two formulas agree.)
///
/// Switching: due when |sigma| > 1, i.e. beyond 180 deg of the current set; afterwards |sigma| <= 1. The comparison is
/// sigma'sigma > 1 + 2^-46, so that rounding cannot ask for two switches in a row; at exactly 180 deg nothing is due
/// and both sets are equally good. Singular at 360 deg only, |sigma| -> infinity. set_index: 0 for what from_dcm chose,
/// toggled by each switch.
class MrpChart {
 public:
  static constexpr int set_count = 2;

  /// The identity.
  MrpChart() = default;
  [[nodiscard]] static MrpChart from_dcm(const Mat3& R_CT);
  [[nodiscard]] static MrpChart from_parameters(const Vec3& sigma_CT, int set_index);

  [[nodiscard]] Mat3 dcm() const;
  [[nodiscard]] const Vec3& parameters() const { return sigma_CT_; }
  [[nodiscard]] int set_index() const { return set_index_; }
  void add(const Vec3& delta) { sigma_CT_ += delta; }

  [[nodiscard]] Mat3 error_jacobian() const;
  [[nodiscard]] Mat3 error_jacobian_inverse() const;
  [[nodiscard]] Vec3 kinematics(const Vec3& omega_C) const;
  [[nodiscard]] MrpChart rotated(const Vec3& phi_C) const;
  [[nodiscard]] MrpChart rotated(const Vec3& phi_C, Mat3& J_new_old, Mat3& J_new_phi) const;

  [[nodiscard]] bool switch_due() const;
  [[nodiscard]] MrpChart switched(Mat3& J_new_old) const;
  [[nodiscard]] bool switch_if_due(Mat3& J_new_old);

 private:
  Vec3 sigma_CT_ = Vec3::Zero();
  int set_index_ = 0;
};

}  // namespace relnav
