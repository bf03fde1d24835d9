#include "hil/scenarios/orbit.hpp"

#include <Eigen/Geometry>
#include <cmath>

namespace relnav::hil {
namespace {

constexpr double earth_mu_m3_s2 = 3.986004418e14;

double eccentric_anomaly(double mean_rad, double e) {
  double E = mean_rad;
  for (int i = 0; i < 20; ++i) E -= (E - e * std::sin(E) - mean_rad) / (1.0 - e * std::cos(E));
  return E;
}

}  // namespace

OrbitState orbit_state(const OrbitElements& o, double t_s) {
  const double n = std::sqrt(earth_mu_m3_s2 / o.semi_major_axis_m) / o.semi_major_axis_m;  // rad/s
  const double E = eccentric_anomaly(n * (t_s - o.perigee_time_s), o.eccentricity);
  const double b = std::sqrt(1.0 - o.eccentricity * o.eccentricity);
  const Vec3 perifocal(o.semi_major_axis_m * (std::cos(E) - o.eccentricity), o.semi_major_axis_m * b * std::sin(E),
                       0.0);
  const Mat3 R_IP =
      (Eigen::AngleAxisd(o.raan_rad, Vec3::UnitZ()) * Eigen::AngleAxisd(o.inclination_rad, Vec3::UnitX()) *
       Eigen::AngleAxisd(o.argument_of_perigee_rad, Vec3::UnitZ()))
          .toRotationMatrix();
  OrbitState state;
  state.r_I = R_IP * perifocal;
  state.R_IL.col(2) = -state.r_I.normalized();
  state.R_IL.col(1) = -R_IP.col(2);
  state.R_IL.col(0) = state.R_IL.col(1).cross(state.R_IL.col(2));
  return state;
}

}  // namespace relnav::hil
