#pragma once
#include <cmath>

#include "fsw/math/types.hpp"

namespace relnav::hil {

// EGM96 (NASA/TP-1998-206861): its GM, equatorial radius and J2 = -sqrt(5) C20.
inline constexpr double earth_mu_m3_s2 = 3.986004418e14;
inline constexpr double earth_radius_m = 6378137.0;
inline constexpr double earth_j2 = 1.0826267e-3;

enum class Gravity { none, point_mass, oblate };

/// At a place relative to the Earth's centre, m/s^2. oblate: with the second zonal harmonic about z_I (Vallado,
/// Fundamentals of Astrodynamics and Applications, 4th ed., section 8.6.1, gradient of the J2 potential).
[[nodiscard]] inline Vec3 gravity_at(Gravity gravity, const Vec3& r_I) {
  if (gravity == Gravity::none) return Vec3::Zero();
  const double r2 = r_I.squaredNorm();
  const double r = std::sqrt(r2);
  Vec3 a_I = -earth_mu_m3_s2 / (r2 * r) * r_I;
  if (gravity == Gravity::oblate) {
    const double scale = -1.5 * earth_j2 * earth_mu_m3_s2 * earth_radius_m * earth_radius_m / (r2 * r2 * r);
    const double sine2 = r_I.z() * r_I.z() / r2;
    a_I += scale * Vec3((1.0 - 5.0 * sine2) * r_I.x(), (1.0 - 5.0 * sine2) * r_I.y(), (3.0 - 5.0 * sine2) * r_I.z());
  }
  return a_I;
}

}  // namespace relnav::hil
