#pragma once
#include "fsw/math/types.hpp"

namespace relnav::hil {

/// Two-body orbit about the Earth.
struct OrbitElements {
  double raan_rad = 0.0;
  double argument_of_perigee_rad = 0.0;
  double inclination_rad = 0.0;
  double eccentricity = 0.0;  ///< 0 .. 0.9
  double semi_major_axis_m = 0.0;
  double perigee_time_s = 0.0;
};

/// Where the spacecraft is, and its local frame L: x along the track (near the velocity), y against the orbit's normal,
/// z to the Earth's centre.
struct OrbitState {
  Vec3 r_I = Vec3::Zero();  ///< m
  Mat3 R_IL = Mat3::Identity();
};

[[nodiscard]] OrbitState orbit_state(const OrbitElements& elements, double t_s);

}  // namespace relnav::hil
