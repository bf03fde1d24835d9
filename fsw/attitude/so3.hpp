#pragma once
/// The rotation group SO(3): active rotations, right-hand rule, rotation vectors phi in rad, |phi| up to
/// math::max_angle (NaN beyond).
/// Source: Sola, Deray, Atchuthan, "A micro Lie theory for state estimation in robotics", arXiv:1812.01537, appendix B
/// (equation numbers there); Barfoot, "State Estimation for Robotics", 2017, section 7.1.
#include "fsw/math/types.hpp"

namespace relnav {

/// [a x], so that [a x] b = a x b.
[[nodiscard]] Mat3 cross_matrix(const Vec3& a);

/// R = Exp([phi x]) = I + [phi x] + [phi x]^2 / 2 + ..., series below |phi| = 0.1.
[[nodiscard]] Mat3 exp_so3(const Vec3& phi);

/// phi with Exp([phi x]) = R and |phi| <= pi, through the quaternion: full precision at 0 and through pi, where
/// either of the two equal answers may come out. R: orthonormal to about 1e-3.
[[nodiscard]] Vec3 log_so3(const Mat3& R);

/// J_l with Exp([(phi + d) x]) = Exp([J_l d x]) Exp([phi x]) + O(d^2) (Sola (145)).
[[nodiscard]] Mat3 left_jacobian_so3(const Vec3& phi);

/// J_r with Exp([(phi + d) x]) = Exp([phi x]) Exp([J_r d x]) + O(d^2); J_r(phi) = J_l(-phi) = J_l(phi)' (Sola (143)).
[[nodiscard]] Mat3 right_jacobian_so3(const Vec3& phi);

/// The rotation nearest to M in the Frobenius norm, its polar factor, by six Newton-Schulz steps
/// (Higham, "Functions of Matrices", SIAM 2008, (8.20)). For det M > 0 and |M'M - I| < 1/2; exact to rounding there.
[[nodiscard]] Mat3 orthonormalise(const Mat3& M);

}  // namespace relnav
