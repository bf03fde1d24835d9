#include "hil/dynamics/orbit.hpp"

#include <Eigen/Geometry>
#include <cmath>

#include "hil/dynamics/gravity.hpp"

namespace relnav::hil {
namespace {

double eccentric_anomaly(double mean_rad, double e) {
  double E = mean_rad;
  for (int i = 0; i < 20; ++i) E -= (E - e * std::sin(E) - mean_rad) / (1.0 - e * std::cos(E));
  return E;
}

}  // namespace

InertialState orbit_state(const OrbitElements& o, double t_s) {
  const double n = std::sqrt(earth_mu_m3_s2 / o.semi_major_axis_m) / o.semi_major_axis_m;  // rad/s
  const double E = eccentric_anomaly(n * (t_s - o.perigee_time_s), o.eccentricity);
  const double b = std::sqrt(1.0 - o.eccentricity * o.eccentricity);
  const double E_rate = n / (1.0 - o.eccentricity * std::cos(E));
  const Vec3 r_P(o.semi_major_axis_m * (std::cos(E) - o.eccentricity), o.semi_major_axis_m * b * std::sin(E), 0.0);
  const Vec3 v_P(-o.semi_major_axis_m * std::sin(E) * E_rate, o.semi_major_axis_m * b * std::cos(E) * E_rate, 0.0);
  const Mat3 R_IP =
      (Eigen::AngleAxisd(o.raan_rad, Vec3::UnitZ()) * Eigen::AngleAxisd(o.inclination_rad, Vec3::UnitX()) *
       Eigen::AngleAxisd(o.argument_of_perigee_rad, Vec3::UnitZ()))
          .toRotationMatrix();
  return {R_IP * r_P, R_IP * v_P};
}

}  // namespace relnav::hil
