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

struct InertialState {
  Vec3 r_I = Vec3::Zero();  ///< from the Earth's centre, m
  Vec3 v_I = Vec3::Zero();  ///< m/s
};

/// Kepler's closed form (Montenbruck, Gill, Satellite Orbits, 2000, section 2.2).
[[nodiscard]] InertialState orbit_state(const OrbitElements& elements, double t_s);

}  // namespace relnav::hil
