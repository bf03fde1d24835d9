#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

#include "hil/render/vec3f.hpp"

namespace relnav::hil {

inline constexpr double sun_radius_rad = 0.00465;  ///< half of 0.533 deg
inline constexpr double earth_radius = 6.371e6;    ///< m

/// What shines on the target, in T. Radiances are in units of that of a white, matt surface that faces the sun.
struct Lighting {
  Vec3f sun_T{};           ///< to the sun's centre
  float sunlight = 1.0F;   ///< share of the disc that is free
  Vec3f earth_T{};         ///< to the Earth's centre
  float earth_sin = 0.0F;  ///< of the angle that the Earth's radius fills
  float earth_cos = 1.0F;
  float earth_radiance = 0.0F;  ///< mean of the part that is in view
  float fill = 0.0F;            ///< from everywhere: light that parts of the target throw on each other
};

/// Eight pieces of surface, number by number, so that a processor shades them together.
struct alignas(32) Patches {
  static constexpr std::size_t size = 8;
  using Numbers = std::array<float, size>;
  Numbers normal_x, normal_y, normal_z;      ///< in T, of any length, on any side
  Numbers face_x, face_y, face_z;            ///< unit normal of the triangle, toward the viewer
  Numbers along_x, along_y, along_z;         ///< along the texture's u
  Numbers tilt_u, tilt_v;                    ///< slopes from the texture
  Numbers viewer_x, viewer_y, viewer_z;      ///< unit vector to the viewer
  Numbers base, metallic, alpha2, emission;  ///< alpha: GGX width
  Numbers lit;                               ///< share of the free disc of the sun that nothing blocks
};

/// Radiance of each toward its viewer.
/// Microfacets: GGX, D of Walter et al., EGSR 2007, (33); shadowing after Schlick's form of its (34) (Karis, SIGGRAPH 2013
/// course); Fresnel: Schlick, CGF 13(3), 1994, (15). The Earth: irradiance of a uniform disc, exact while it is above the
/// surface's horizon and falling like a parabola while it sets; mirrored with an edge as soft as the surface is rough.
void shade(const Patches& patches, const Lighting& light, Patches::Numbers& radiance);

}  // namespace relnav::hil
