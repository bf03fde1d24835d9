#include "fsw/attitude/rodrigues.hpp"

#include <cmath>

#include "fsw/attitude/quaternion.hpp"
#include "fsw/attitude/so3.hpp"
#include "fsw/base/panic.hpp"

namespace relnav {

static_assert(AttitudeChart<RodriguesChart>);

namespace {

// A Gibbs vector with its denominator not yet divided out: g = vector / scalar. Up to scale, a quaternion in Shuster's
// convention. Stays finite where g does not.
struct HomogeneousGibbs {
  Vec3 vector;
  double scalar;
};

int largest_component(const Vec3& v) {
  const double x = std::fabs(v.x());
  const double y = std::fabs(v.y());
  const double z = std::fabs(v.z());
  if (x >= y && x >= z) return 0;
  return y >= z ? 1 : 2;
}

// (10), a * b: the denominator kept apart.
HomogeneousGibbs compose(const HomogeneousGibbs& a, const HomogeneousGibbs& b) {
  return {b.scalar * a.vector + a.scalar * b.vector - cross_matrix(a.vector) * b.vector,
          a.scalar * b.scalar - a.vector.dot(b.vector)};
}

// Numerator of (5), T_j(g) = -(e_j + e_j x g) / g_j for g = vector / scalar; the denominator is vector[j].
Vec3 switch_numerator(const HomogeneousGibbs& h, int j) {
  Vec3 e = Vec3::Zero();
  e[j] = 1.0;
  Vec3 numerator = -(cross_matrix(e) * h.vector);
  numerator[j] = -h.scalar;
  return numerator;
}

// (5), new index after T_j, j = 1..3.
int switched_index(int i, int j) {
  if (i == 0) return j;
  return i == j ? 0 : 6 - j - i;
}

}  // namespace

RodriguesChart RodriguesChart::from_dcm(const Mat3& R_CT) {
  const Quaternion q_CT = Quaternion::from_dcm(R_CT);
  const HomogeneousGibbs h{-q_CT.vector(), q_CT.w};
  const int j = largest_component(h.vector);
  if (std::fabs(h.vector[j]) > h.scalar) return from_parameters(switch_numerator(h, j) / h.vector[j], j + 1);
  return from_parameters(h.vector / h.scalar, 0);
}

RodriguesChart RodriguesChart::from_parameters(const Vec3& g_CT, int set_index) {
  RELNAV_ASSERT(set_index >= 0 && set_index < set_count);
  RodriguesChart chart;
  chart.g_CT_ = g_CT;
  chart.set_index_ = set_index;
  return chart;
}

Mat3 RodriguesChart::dcm() const {
  const double scale = 1.0 / (1.0 + g_CT_.squaredNorm());
  const double norm_scale = std::sqrt(scale);
  // C(g) is the active rotation of the Hamilton quaternion (-g, 1) / sqrt(1 + g'g).
  Mat3 R_CT = Quaternion::from_parts(-norm_scale * g_CT_, norm_scale).dcm();
  // C(g) R^(i): the two columns other than i change sign.
  if (set_index_ != 0) {
    for (int k = 0; k < 3; ++k) {
      if (k != set_index_ - 1) R_CT.col(k) = -R_CT.col(k);
    }
  }
  return R_CT;
}

Mat3 RodriguesChart::error_jacobian() const {
  return (-2.0 / (1.0 + g_CT_.squaredNorm())) * (Mat3::Identity() - cross_matrix(g_CT_));
}

Mat3 RodriguesChart::error_jacobian_inverse() const {
  return -0.5 * (Mat3::Identity() + cross_matrix(g_CT_) + g_CT_ * g_CT_.transpose());
}

Vec3 RodriguesChart::kinematics(const Vec3& omega_C) const { return error_jacobian_inverse() * omega_C; }

RodriguesChart RodriguesChart::rotated(const Vec3& phi_C) const {
  const Quaternion q_phi = Quaternion::from_rotation_vector(phi_C);
  const HomogeneousGibbs delta{-q_phi.vector(), q_phi.w};
  const HomogeneousGibbs h = compose(delta, {g_CT_, 1.0});
  constexpr double bound2 = same_set_bound * same_set_bound;
  if (h.vector.squaredNorm() > bound2 * h.scalar * h.scalar) {
    const int j = largest_component(h.vector);
    return from_parameters(switch_numerator(h, j) / h.vector[j], switched_index(set_index_, j + 1));
  }
  return from_parameters(h.vector / h.scalar, set_index_);
}

// Exp(phi) Exp(A dp) R = Exp(Exp(phi) A dp) Exp(phi) R, and Exp(phi + dphi) = Exp(J_l dphi) Exp(phi).
RodriguesChart RodriguesChart::rotated(const Vec3& phi_C, Mat3& J_new_old, Mat3& J_new_phi) const {
  const RodriguesChart result = rotated(phi_C);
  const Mat3 A_new_inverse = result.error_jacobian_inverse();
  const Mat3 R_phi_A = exp_so3(phi_C) * error_jacobian();
  J_new_old = A_new_inverse * R_phi_A;
  J_new_phi = A_new_inverse * left_jacobian_so3(phi_C);
  return result;
}

bool RodriguesChart::switch_due() const { return std::fabs(g_CT_[largest_component(g_CT_)]) > 1.0; }

RodriguesChart RodriguesChart::switched(Mat3& J_new_old) const {
  if (!(g_CT_.squaredNorm() >= 1.0 / 16.0)) {
    J_new_old = Mat3::Identity();
    return *this;
  }
  const int j = largest_component(g_CT_);
  Vec3 e = Vec3::Zero();
  e[j] = 1.0;
  const Vec3 g_new = switch_numerator({g_CT_, 1.0}, j) / g_CT_[j];
  // T_j(g) g_j = -(e_j + e_j x g), differentiated.
  J_new_old = (-1.0 / g_CT_[j]) * (cross_matrix(e) + g_new * e.transpose());
  return from_parameters(g_new, switched_index(set_index_, j + 1));
}

bool RodriguesChart::switch_if_due(Mat3& J_new_old) {
  if (!switch_due()) {
    J_new_old = Mat3::Identity();
    return false;
  }
  *this = switched(J_new_old);
  return true;
}

}  // namespace relnav
