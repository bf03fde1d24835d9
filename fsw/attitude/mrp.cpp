#include "fsw/attitude/mrp.hpp"

#include "fsw/attitude/quaternion.hpp"
#include "fsw/attitude/so3.hpp"
#include "fsw/base/panic.hpp"

namespace relnav {

static_assert(AttitudeChart<MrpChart>);

namespace {

// (v, w) = (2 sigma, 1 - sigma'sigma) / (1 + sigma'sigma): unit, w < 0 beyond 180 deg, so the set is kept.
Quaternion quaternion_of(const Vec3& sigma) {
  const double s2 = sigma.squaredNorm();
  const double scale = 1.0 / (1.0 + s2);
  return Quaternion::from_parts((2.0 * scale) * sigma, (1.0 - s2) * scale);
}

}  // namespace

MrpChart MrpChart::from_dcm(const Mat3& R_CT) {
  const Quaternion q_CT = Quaternion::from_dcm(R_CT);
  return from_parameters(q_CT.vector() / (1.0 + q_CT.w), 0);
}

MrpChart MrpChart::from_parameters(const Vec3& sigma_CT, int set_index) {
  RELNAV_ASSERT(set_index >= 0 && set_index < set_count);
  MrpChart chart;
  chart.sigma_CT_ = sigma_CT;
  chart.set_index_ = set_index;
  return chart;
}

Mat3 MrpChart::dcm() const { return quaternion_of(sigma_CT_).dcm(); }

// sigma_dot = B omega_C and B B' = ((1 + s's) / 4)^2 I, so that B^-1 = (4 / (1 + s's))^2 B'.
Mat3 MrpChart::error_jacobian() const {
  const double s2 = sigma_CT_.squaredNorm();
  const double scale = 4.0 / ((1.0 + s2) * (1.0 + s2));
  return scale *
         ((1.0 - s2) * Mat3::Identity() + 2.0 * cross_matrix(sigma_CT_) + 2.0 * sigma_CT_ * sigma_CT_.transpose());
}

Mat3 MrpChart::error_jacobian_inverse() const {
  return 0.25 * ((1.0 - sigma_CT_.squaredNorm()) * Mat3::Identity() - 2.0 * cross_matrix(sigma_CT_) +
                 2.0 * sigma_CT_ * sigma_CT_.transpose());
}

Vec3 MrpChart::kinematics(const Vec3& omega_C) const { return error_jacobian_inverse() * omega_C; }

MrpChart MrpChart::rotated(const Vec3& phi_C) const {
  const Quaternion q = multiply(Quaternion::from_rotation_vector(phi_C), quaternion_of(sigma_CT_));
  // |sigma|^2 = (1 - w) / (1 + w) for a unit quaternion.
  constexpr double bound2 = same_set_bound * same_set_bound;
  if (1.0 - q.w > bound2 * (1.0 + q.w)) {
    return from_parameters(q.vector() / (q.w - 1.0), 1 - set_index_);
  }
  return from_parameters(q.vector() / (1.0 + q.w), set_index_);
}

// Exp(phi) Exp(A dp) R = Exp(Exp(phi) A dp) Exp(phi) R, and Exp(phi + dphi) = Exp(J_l dphi) Exp(phi).
MrpChart MrpChart::rotated(const Vec3& phi_C, Mat3& J_new_old, Mat3& J_new_phi) const {
  const MrpChart result = rotated(phi_C);
  const Mat3 A_new_inverse = result.error_jacobian_inverse();
  const Mat3 R_phi_A = exp_so3(phi_C) * error_jacobian();
  J_new_old = A_new_inverse * R_phi_A;
  J_new_phi = A_new_inverse * left_jacobian_so3(phi_C);
  return result;
}

bool MrpChart::switch_due() const { return sigma_CT_.squaredNorm() > 1.0 + 0x1p-46; }

MrpChart MrpChart::switched(Mat3& J_new_old) const {
  const double s2 = sigma_CT_.squaredNorm();
  if (!(s2 >= 1.0 / 16.0)) {
    J_new_old = Mat3::Identity();
    return *this;
  }
  J_new_old = (2.0 / (s2 * s2)) * sigma_CT_ * sigma_CT_.transpose() - (1.0 / s2) * Mat3::Identity();
  return from_parameters(-sigma_CT_ / s2, 1 - set_index_);
}

bool MrpChart::switch_if_due(Mat3& J_new_old) {
  if (!switch_due()) {
    J_new_old = Mat3::Identity();
    return false;
  }
  *this = switched(J_new_old);
  return true;
}

}  // namespace relnav
