#include "hil/render/lighting.hpp"

#include <cmath>

#include "hil/render/any_width.hpp"

namespace relnav::hil {
namespace {

inline float larger(float a, float b) { return a > b ? a : b; }
inline float smaller(float a, float b) { return a < b ? a : b; }

}  // namespace

// One loop without branches, for the compiler to make vectors of.
RELNAV_ANY_WIDTH void shade(const Patches& patches, const Lighting& light, Patches::Numbers& radiance) {
  const Patches& p = patches;
  const Lighting l = light;
  // The sun is no point: the half vector scatters by a quarter of its radius along each axis.
  constexpr auto of_disc = static_cast<float>(sun_radius_rad * sun_radius_rad / 8.0);
  const float setting = l.earth_sin > 0.0F ? 0.25F / l.earth_sin : 0.0F;
  for (std::size_t i = 0; i < Patches::size; ++i) {
    const float vx = p.viewer_x[i];
    const float vy = p.viewer_y[i];
    const float vz = p.viewer_z[i];
    // Smoothed normal, on the viewer's side, tilted by the texture.
    float nx = p.normal_x[i];
    float ny = p.normal_y[i];
    float nz = p.normal_z[i];
    const float side = nx * p.face_x[i] + ny * p.face_y[i] + nz * p.face_z[i];
    float scale = (side < 0.0F ? -1.0F : 1.0F) / std::sqrt(larger(nx * nx + ny * ny + nz * nz, 1e-20F));
    nx *= scale;
    ny *= scale;
    nz *= scale;
    const float on = p.along_x[i] * nx + p.along_y[i] * ny + p.along_z[i] * nz;
    float sx = p.along_x[i] - on * nx;
    float sy = p.along_y[i] - on * ny;
    float sz = p.along_z[i] - on * nz;
    scale = 1.0F / std::sqrt(larger(sx * sx + sy * sy + sz * sz, 1e-20F));
    sx *= scale;
    sy *= scale;
    sz *= scale;
    const float tu = p.tilt_u[i];
    const float tv = p.tilt_v[i];
    const float mx = nx + tu * sx + tv * (ny * sz - nz * sy);
    const float my = ny + tu * sy + tv * (nz * sx - nx * sz);
    const float mz = nz + tu * sz + tv * (nx * sy - ny * sx);
    scale = 1.0F / std::sqrt(larger(mx * mx + my * my + mz * mz, 1e-20F));
    nx = mx * scale;
    ny = my * scale;
    nz = mz * scale;

    const float alpha2 = smaller(p.alpha2[i] + of_disc, 1.0F);
    const float alpha = std::sqrt(alpha2);
    const float n_v = nx * vx + ny * vy + nz * vz;
    const float nv = larger(n_v, 0.05F);
    const float f0 = 0.04F + p.metallic[i] * (p.base[i] - 0.04F);
    const float matt = (1.0F - p.metallic[i]) * p.base[i];

    // Sun.
    const float nl = larger(nx * l.sun_T.x + ny * l.sun_T.y + nz * l.sun_T.z, 0.0F);
    float hx = l.sun_T.x + vx;
    float hy = l.sun_T.y + vy;
    float hz = l.sun_T.z + vz;
    scale = 1.0F / std::sqrt(larger(hx * hx + hy * hy + hz * hz, 1e-20F));
    hx *= scale;
    hy *= scale;
    hz *= scale;
    const float nh = larger(nx * hx + ny * hy + nz * hz, 0.0F);
    const float vh = larger(vx * hx + vy * hy + vz * hz, 0.0F);
    const float d = nh * nh * (alpha2 - 1.0F) + 1.0F;
    const float k = 0.5F * alpha;
    // GGX times pi, which the unit of radiance takes away, over its shadowing's denominator.
    const float mirror = 0.25F * alpha2 / (d * d * (nl * (1.0F - k) + k) * (nv * (1.0F - k) + k));
    const float c = 1.0F - smaller(vh, 1.0F);
    const float fresnel = f0 + (1.0F - f0) * (c * c) * (c * c) * c;
    const float sun = l.sunlight * p.lit[i] * nl * ((1.0F - fresnel) * matt + fresnel * mirror);

    // Earth.
    const float ne = nx * l.earth_T.x + ny * l.earth_T.y + nz * l.earth_T.z;
    const float above = larger(ne + l.earth_sin, 0.0F);
    const float share = ne < l.earth_sin ? above * above * setting : ne;
    const float g = 1.0F - smaller(nv, 1.0F);
    const float grazing = f0 + (1.0F - f0) * (g * g) * (g * g) * g * (1.0F - alpha);
    const float twice = 2.0F * n_v;
    const float mirrored =
        (twice * nx - vx) * l.earth_T.x + (twice * ny - vy) * l.earth_T.y + (twice * nz - vz) * l.earth_T.z;
    const float edge = (mirrored - l.earth_cos) / (0.04F + 2.0F * alpha) + 0.5F;
    const float inside = smaller(larger(edge, 0.0F), 1.0F);
    const float earth = l.earth_radiance * ((1.0F - grazing) * matt * l.earth_sin * l.earth_sin * share +
                                            grazing * inside * inside * (3.0F - 2.0F * inside));

    radiance[i] = p.emission[i] + sun + earth + l.fill * (matt + f0);
  }
}

}  // namespace relnav::hil
