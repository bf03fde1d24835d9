#include "hil/dynamics/lvlh.hpp"

#include <Eigen/Geometry>
#include <cmath>

namespace relnav::hil {

Turning local_frame(const InertialState& s, Gravity gravity) {
  const Vec3 h_I = s.r_I.cross(s.v_I);
  const double h = h_I.norm();
  Turning il;
  il.R_AB.col(2) = -s.r_I.normalized();
  il.R_AB.col(1) = -h_I / h;
  il.R_AB.col(0) = il.R_AB.col(1).cross(il.R_AB.col(2));
  // In the plane h / r^2; and an acceleration along the normal turns the plane about r.
  il.omega_AB_A = h_I / s.r_I.squaredNorm() + gravity_at(gravity, s.r_I).dot(h_I) / (h * h) * s.r_I;
  return il;
}

LocalState local_state(const InertialState& other, const InertialState& origin, const Turning& il) {
  const Vec3 p_I = other.r_I - origin.r_I;
  const Vec3 v_I = other.v_I - origin.v_I - il.omega_AB_A.cross(p_I);
  return {il.R_AB.transpose() * p_I, il.R_AB.transpose() * v_I};
}

InertialState inertial_state(const LocalState& other, const InertialState& origin, const Turning& il) {
  const Vec3 p_I = il.R_AB * other.p_L;
  return {origin.r_I + p_I, origin.v_I + il.R_AB * other.v_L + il.omega_AB_A.cross(p_I)};
}

LocalState clohessy_wiltshire(const LocalState& start, double n, double t_s) {
  const double s = std::sin(n * t_s);
  const double c = std::cos(n * t_s);
  const Vec3& p = start.p_L;
  const Vec3 u = start.v_L / n;
  LocalState at;
  at.p_L.x() =
      (4.0 * u.x() - 6.0 * p.z()) * s - 2.0 * u.z() * c + (6.0 * p.z() - 3.0 * u.x()) * n * t_s + p.x() + 2.0 * u.z();
  at.p_L.y() = p.y() * c + u.y() * s;
  at.p_L.z() = (2.0 * u.x() - 3.0 * p.z()) * c + u.z() * s + 4.0 * p.z() - 2.0 * u.x();
  at.v_L.x() = n * ((4.0 * u.x() - 6.0 * p.z()) * c + 2.0 * u.z() * s + 6.0 * p.z() - 3.0 * u.x());
  at.v_L.y() = n * (-p.y() * s + u.y() * c);
  at.v_L.z() = n * (-(2.0 * u.x() - 3.0 * p.z()) * s + u.z() * c);
  return at;
}

}  // namespace relnav::hil
