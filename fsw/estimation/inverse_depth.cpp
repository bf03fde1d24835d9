#include "fsw/estimation/inverse_depth.hpp"

#include <cmath>
#include <limits>

#include "fsw/math/elementary.hpp"

namespace relnav::inverse_depth {

Vec3 ray_T(double theta, double phi) {
  const math::SinCos at = math::sincos(theta);
  const math::SinCos el = math::sincos(phi);
  return {el.cos * at.sin, -el.sin, el.cos * at.cos};
}

Vec3 ray_T(double theta, double phi, Vec3& dm_dtheta, Vec3& dm_dphi) {
  const math::SinCos at = math::sincos(theta);
  const math::SinCos el = math::sincos(phi);
  dm_dtheta = Vec3(el.cos * at.cos, 0.0, -el.cos * at.sin);
  dm_dphi = Vec3(-el.sin * at.sin, -el.cos, -el.sin * at.cos);
  return {el.cos * at.sin, -el.sin, el.cos * at.cos};
}

void angles_of(const Vec3& direction_T, double& theta, double& phi, Mat23& J) {
  const double x = direction_T.x();
  const double y = direction_T.y();
  const double z = direction_T.z();
  const double h2 = x * x + z * z;
  const double h = std::sqrt(h2);
  const double d2 = h2 + y * y;
  theta = math::atan2(x, z);
  phi = math::atan2(-y, h);
  J.setZero();
  if (h2 > 0.0) {
    J(0, 0) = z / h2;
    J(0, 2) = -x / h2;
    J(1, 0) = y * x / (d2 * h);
    J(1, 1) = -h / d2;
    J(1, 2) = y * z / (d2 * h);
  }
}

Vec3 point_T(const Vec6& y, Mat<3, 6>& J) {
  Vec3 dm_dtheta;
  Vec3 dm_dphi;
  const Vec3 m = ray_T(y(3), y(4), dm_dtheta, dm_dphi);
  const double d = 1.0 / y(5);
  J.block<3, 3>(0, 0).setIdentity();
  J.col(3) = d * dm_dtheta;
  J.col(4) = d * dm_dphi;
  J.col(5) = -(d * d) * m;
  return y.head<3>() + d * m;
}

double euclidean_linearity_index(const Vec6& y, double sigma_rho, const Vec3& r_TC) {
  if (!(y(5) > 0.0)) return std::numeric_limits<double>::infinity();
  const double d0 = 1.0 / y(5);
  const Vec3 m = ray_T(y(3), y(4));
  const Vec3 from_camera = y.head<3>() + d0 * m - r_TC;
  const double d1 = from_camera.norm();
  if (!(d1 > 0.0)) return std::numeric_limits<double>::infinity();
  const double cos_alpha = m.dot(from_camera) / d1;
  const double sigma_d = sigma_rho * d0 * d0;
  return 4.0 * sigma_d / d1 * (cos_alpha < 0.0 ? -cos_alpha : cos_alpha);
}

}  // namespace relnav::inverse_depth
