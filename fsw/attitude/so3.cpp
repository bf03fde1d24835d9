#include "fsw/attitude/so3.hpp"

#include <cmath>

#include "fsw/attitude/quaternion.hpp"
#include "fsw/math/elementary.hpp"

namespace relnav {
namespace {

// Coefficients of the exponential and of its Jacobian, functions of theta = |phi| only.
struct RotationCoefficients {
  double sine;    // sin(theta) / theta
  double cosine;  // (1 - cos(theta)) / theta^2
  double cubic;   // (theta - sin(theta)) / theta^3
};

RotationCoefficients rotation_coefficients(double theta2) {
  constexpr double series_limit = 0.01;  // theta^2; the first omitted term is below 3e-16 of the sum there
  if (theta2 < series_limit) {
    return {1.0 - theta2 / 6.0 * (1.0 - theta2 / 20.0 * (1.0 - theta2 / 42.0 * (1.0 - theta2 / 72.0))),
            0.5 - theta2 / 24.0 * (1.0 - theta2 / 30.0 * (1.0 - theta2 / 56.0 * (1.0 - theta2 / 90.0))),
            1.0 / 6.0 - theta2 / 120.0 * (1.0 - theta2 / 42.0 * (1.0 - theta2 / 72.0 * (1.0 - theta2 / 110.0)))};
  }
  const double theta = std::sqrt(theta2);
  const math::SinCos half = math::sincos(0.5 * theta);
  const double sin_theta = 2.0 * half.sin * half.cos;
  return {sin_theta / theta, 2.0 * half.sin * half.sin / theta2, (theta - sin_theta) / (theta2 * theta)};
}

// [a x]^2 = a a' - (a'a) I
Mat3 cross_matrix_squared(const Vec3& a) { return a * a.transpose() - a.squaredNorm() * Mat3::Identity(); }

}  // namespace

Mat3 cross_matrix(const Vec3& a) {
  Mat3 M;
  M << 0.0, -a.z(), a.y(),  //
      a.z(), 0.0, -a.x(),   //
      -a.y(), a.x(), 0.0;
  return M;
}

Mat3 exp_so3(const Vec3& phi) {
  const RotationCoefficients k = rotation_coefficients(phi.squaredNorm());
  return Mat3::Identity() + k.sine * cross_matrix(phi) + k.cosine * cross_matrix_squared(phi);
}

Vec3 log_so3(const Mat3& R) { return Quaternion::from_dcm(R).rotation_vector(); }

Mat3 left_jacobian_so3(const Vec3& phi) {
  const RotationCoefficients k = rotation_coefficients(phi.squaredNorm());
  return Mat3::Identity() + k.cosine * cross_matrix(phi) + k.cubic * cross_matrix_squared(phi);
}

Mat3 right_jacobian_so3(const Vec3& phi) { return left_jacobian_so3(-phi); }

Mat3 orthonormalise(const Mat3& M) {
  Mat3 R = M;
  for (int step = 0; step < 6; ++step) {
    const Mat3 excess = R.transpose() * R - Mat3::Identity();
    R -= 0.5 * (R * excess);
  }
  return R;
}

}  // namespace relnav
