#include "fsw/attitude/quaternion.hpp"

#include <cmath>

#include "fsw/math/elementary.hpp"

namespace relnav {

Quaternion Quaternion::from_dcm(const Mat3& R) {
  // 4 q_i^2 for each component; the largest is at least 1.
  const double w2 = 1.0 + R(0, 0) + R(1, 1) + R(2, 2);
  const double x2 = 1.0 + R(0, 0) - R(1, 1) - R(2, 2);
  const double y2 = 1.0 - R(0, 0) + R(1, 1) - R(2, 2);
  const double z2 = 1.0 - R(0, 0) - R(1, 1) + R(2, 2);
  // 4 q_i q_j, formed from the pivot's row; the normalisation removes the common factor.
  const double wx = R(2, 1) - R(1, 2);
  const double wy = R(0, 2) - R(2, 0);
  const double wz = R(1, 0) - R(0, 1);
  const double xy = R(0, 1) + R(1, 0);
  const double xz = R(0, 2) + R(2, 0);
  const double yz = R(1, 2) + R(2, 1);
  Quaternion q;
  if (w2 >= x2 && w2 >= y2 && w2 >= z2) {
    q = {wx, wy, wz, w2};
  } else if (x2 >= y2 && x2 >= z2) {
    q = {x2, xy, xz, wx};
  } else if (y2 >= z2) {
    q = {xy, y2, yz, wy};
  } else {
    q = {xz, yz, z2, wz};
  }
  return q.normalised().canonical();
}

Quaternion Quaternion::from_rotation_vector(const Vec3& phi) {
  const double half2 = 0.25 * phi.squaredNorm();
  double sinc = 1.0;  // sin(|phi|/2) / (|phi|/2)
  double w = 1.0;
  constexpr double series_limit = 1e-3;  // (|phi|/2)^2; the first omitted term is below 3e-18 there
  if (half2 < series_limit) {
    sinc = 1.0 - half2 / 6.0 * (1.0 - half2 / 20.0 * (1.0 - half2 / 42.0));
    w = 1.0 - half2 / 2.0 * (1.0 - half2 / 12.0 * (1.0 - half2 / 30.0 * (1.0 - half2 / 56.0)));
  } else {
    const double half = std::sqrt(half2);
    const math::SinCos of_half = math::sincos(half);
    sinc = of_half.sin / half;
    w = of_half.cos;
  }
  return from_parts(0.5 * sinc * phi, w);
}

Quaternion Quaternion::normalised() const {
  const double scale = 1.0 / std::sqrt(squared_norm());
  return {scale * x, scale * y, scale * z, scale * w};
}

Mat3 Quaternion::dcm() const {
  Mat3 R;
  R << 1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y),  //
      2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x),   //
      2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y);
  return R;
}

Vec3 Quaternion::rotation_vector() const {
  const Quaternion q = canonical();
  const Vec3 v = q.vector();
  const double v2 = v.squaredNorm();
  constexpr double series_limit = 1e-8;  // |v|^2 = sin^2(theta/2); the first omitted term is below 2e-17 there
  if (v2 < series_limit) return (2.0 / q.w) * (1.0 - v2 / (3.0 * q.w * q.w)) * v;
  const double sine = std::sqrt(v2);
  return (2.0 * math::atan2(sine, q.w) / sine) * v;
}

Quaternion multiply(const Quaternion& a, const Quaternion& b) {
  return {a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,  //
          a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,  //
          a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w,  //
          a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z};
}

}  // namespace relnav
