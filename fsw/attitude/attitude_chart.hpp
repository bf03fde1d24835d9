#pragma once
#include <concepts>

#include "fsw/math/types.hpp"

namespace relnav {

/// Largest |p| for which rotated() stays in the set it started from. At 4 a chart is still well conditioned (MRP: 304
/// deg, Rodrigues: 152 deg from the set's own zero); a due switch brings |p| back to 1 (MRP) or sqrt(3) (Rodrigues).
inline constexpr double same_set_bound = 4.0;

/// A three-parameter chart of SO(3) with a switching rule. The attitude is R_CT (p_C = R_CT p_T + t_CT); p are the
/// parameters. Small rotations are active, expressed in C, and act from the left: R(p + dp) = Exp([A dp x]) R(p) +
/// O(dp^2).
///
///   from_dcm(R_CT)            in the best set, no switch due; precondition: R_CT orthonormal to about 1e-3
///   from_parameters(p, set)   restores a chart; set within 0 .. set_count - 1
///   dcm()                     R_CT, orthonormal to rounding for any finite |p| < 1e100
///   add(delta)                p += delta, the additive correction of an EKF; does not switch
///   error_jacobian()          A: dphi_C = A dp, so P_phi = A P_p A'
///   error_jacobian_inverse()  A^-1, in closed form
///   kinematics(omega_C)       dp/dt for R' = [omega_C x] R, i.e. A^-1 omega_C
///   rotated(phi_C[, J, J])    chart of Exp([phi_C x]) R_CT, exact (composed as quaternions), any |phi_C| <= 1e6;
///                             d p_new / d p and d p_new / d phi_C. In the same set while |p_new| <= same_set_bound;
///                             beyond, the result is in its best set already, and so are the Jacobians.
///   switch_due()              the switching rule
///   switched(J)               the same rotation in the set that the rule names, due or not; J = d p_new / d p, so that
///                             P_new = J P J'. For |p| < 1/4, where no switch makes sense, the chart itself with J = I.
///   switch_if_due(J)          switches in place and says so; J = I otherwise. One call is always enough.
///
/// A NaN anywhere yields NaN parameters, never a trap or an endless loop.
template <typename Chart>
concept AttitudeChart = std::copyable<Chart> &&
    requires(Chart chart, const Chart fixed, const Vec3& vector, const Mat3& matrix, Mat3& out, int index) {
  { Chart::from_dcm(matrix) } -> std::same_as<Chart>;
  { Chart::from_parameters(vector, index) } -> std::same_as<Chart>;
  { Chart::set_count } -> std::convertible_to<int>;
  { fixed.dcm() } -> std::same_as<Mat3>;
  { fixed.parameters() } -> std::same_as<const Vec3&>;
  { fixed.set_index() } -> std::same_as<int>;
  { chart.add(vector) } -> std::same_as<void>;
  { fixed.error_jacobian() } -> std::same_as<Mat3>;
  { fixed.error_jacobian_inverse() } -> std::same_as<Mat3>;
  { fixed.kinematics(vector) } -> std::same_as<Vec3>;
  { fixed.rotated(vector) } -> std::same_as<Chart>;
  { fixed.rotated(vector, out, out) } -> std::same_as<Chart>;
  { fixed.switch_due() } -> std::same_as<bool>;
  { fixed.switched(out) } -> std::same_as<Chart>;
  { chart.switch_if_due(out) } -> std::same_as<bool>;
};

}  // namespace relnav
