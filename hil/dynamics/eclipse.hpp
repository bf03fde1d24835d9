#pragma once
#include "fsw/math/types.hpp"

namespace relnav::hil {

inline constexpr double sun_distance_m = 149597870700.0;  ///< fixed: 1.7 % at most from the truth
inline constexpr double sun_radius_m = 695.7e6;           ///< IAU 2015 resolution B3

/// Share of the sun's disc that the Earth (a ball of its equatorial radius, without air) leaves free at `r_I`, 0 .. 1;
/// `sun_I`: unit vector from the Earth to the sun. Two overlapping discs: Montenbruck, Gill, Satellite Orbits, 2000,
/// section 3.4.2.
[[nodiscard]] double sunlight_at(const Vec3& r_I, const Vec3& sun_I);

}  // namespace relnav::hil
