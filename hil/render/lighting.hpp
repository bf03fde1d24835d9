#pragma once
#include <algorithm>
#include <cmath>

#include "hil/render/mesh_scene.hpp"

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

/// Radiance of a surface toward `to_viewer_T`. `lit`: share of the free disc of the sun that nothing blocks.
/// `footprint`: of a pixel on the surface, m.
/// Microfacets: GGX, D of Walter et al., EGSR 2007, (33); shadowing after Schlick's form of its (34) (Karis, SIGGRAPH 2013
/// course); Fresnel: Schlick, CGF 13(3), 1994, (15).
inline float radiance_of(const Surface& surface, const Material& material, const Texture* texture,
                         const Lighting& light, Vec3f to_viewer_T, float lit, float footprint) {
  Vec3f n = surface.normal_T;
  const float facing = std::max(dot(surface.face_T, to_viewer_T), 0.05F);
  float base = material.base;
  const float metallic = material.metallic;
  const float width = material.roughness * material.roughness;
  // The sun is no point: the half vector scatters by a quarter of its radius along each axis.
  constexpr float of_disc = static_cast<float>(sun_radius_rad * sun_radius_rad / 8.0);
  float alpha2 = width * width + of_disc;
  if (texture != nullptr) {
    // The longer axis of the footprint grows with 1 / facing, the shorter does not: in between.
    const Texel texel = texture->at(surface.u, surface.v, footprint * surface.per_metre / std::sqrt(facing));
    base = std::min(base * texel.base(), 1.0F);
    alpha2 += texel.alpha2();
    const Vec3f s = normalized(surface.along_u_T - dot(surface.along_u_T, n) * n);
    n = normalized(n + texel.tilt_u() * s + texel.tilt_v() * cross(n, s));
  }
  alpha2 = std::min(alpha2, 1.0F);
  const float nv = std::max(dot(n, to_viewer_T), 0.05F);
  const float f0 = 0.04F + metallic * (base - 0.04F);
  const float matt = (1.0F - metallic) * base;

  float out = material.emission;
  const float nl = dot(n, light.sun_T);
  if (lit > 0.0F && nl > 0.0F) {
    const Vec3f h = normalized(light.sun_T + to_viewer_T);
    const float nh = std::max(dot(n, h), 0.0F);
    const float vh = std::max(dot(to_viewer_T, h), 0.0F);
    const float d = nh * nh * (alpha2 - 1.0F) + 1.0F;
    const float ggx = alpha2 / (d * d);  // times 1 / pi, which the unit of radiance takes away
    const float k = 0.5F * std::sqrt(alpha2);
    const float shadowing = 0.25F / ((nl * (1.0F - k) + k) * (nv * (1.0F - k) + k));
    const float c = 1.0F - vh;
    const float c2 = c * c;
    const float fresnel = f0 + (1.0F - f0) * c2 * c2 * c;
    out += light.sunlight * lit * nl * ((1.0F - fresnel) * matt + fresnel * ggx * shadowing);
  }

  // A uniform disc in the sky: its irradiance above the horizon is exact, while it sets a parabola.
  const float ne = dot(n, light.earth_T);
  float share = ne;
  if (ne < light.earth_sin) {
    const float above = std::max(ne + light.earth_sin, 0.0F);
    share = light.earth_sin > 0.0F ? above * above / (4.0F * light.earth_sin) : 0.0F;
  }
  const float c = 1.0F - nv;
  const float c2 = c * c;
  const float fresnel = f0 + (1.0F - f0) * c2 * c2 * c * (1.0F - std::sqrt(alpha2));
  out += (1.0F - fresnel) * matt * light.earth_radiance * light.earth_sin * light.earth_sin * share;
  // Mirrored: the disc's edge as soft as the surface is rough.
  const Vec3f mirrored = 2.0F * dot(n, to_viewer_T) * n - to_viewer_T;
  const float soft = 0.02F + std::sqrt(alpha2);
  const float edge = (dot(mirrored, light.earth_T) - light.earth_cos) / (2.0F * soft) + 0.5F;
  const float inside = std::clamp(edge, 0.0F, 1.0F);
  out += fresnel * light.earth_radiance * inside * inside * (3.0F - 2.0F * inside);
  return out + light.fill * (matt + f0);
}

}  // namespace relnav::hil
