// Small scenes with known answers.
#pragma once
#include <Eigen/Geometry>
#include <cmath>
#include <cstring>
#include <numbers>

#include "hil/render/mesh_builder.hpp"
#include "hil/render/scene_renderer.hpp"

namespace relnav::test {

inline CameraModel camera_of(std::int32_t width_px, std::int32_t height_px, double focal_px, bool is_distorted) {
  CameraIntrinsics k;
  k.fu = focal_px;
  k.fv = 1.002 * focal_px;
  k.cu = 0.5 * width_px + 2.3;
  k.cv = 0.5 * height_px - 3.7;
  k.width_px = width_px;
  k.height_px = height_px;
  if (is_distorted) {
    k.model = DistortionModel::radial_tangential;
    k.coefficients = {-0.12, 0.05, 0.001, -0.0007};
  }
  return CameraModel::create(k).value();
}

/// Without noise and halo, black around; 16 bits, so that levels are as good as radiance.
inline hil::RenderSettings plain_settings() {
  hil::RenderSettings s;
  s.fill = 0.0;
  s.earth = false;
  s.stars = false;
  s.spread.halo_share = 0.0;
  s.sensor.noise = false;
  s.sensor.response_sd = 0.0;
  s.sensor.dark_level = 0.0;
  s.sensor.dark_current_e_s = 0.0;
  s.sensor.bits = 16;
  return s;
}
/// A white surface in full sun reaches a quarter of the highest level, with plain_settings().
inline constexpr double quarter_s = 0.25 * 20'000.0 / 2e7;

/// Square in the plane z of T, seen from -Z.
inline void add_square(hil::MeshBuilder& builder, double x, double y, double z, double half, std::uint32_t material) {
  const auto f = [](double value) { return static_cast<float>(value); };
  builder.add_polygon({{f(x - half), f(y - half), f(z)},
                       {f(x - half), f(y + half), f(z)},
                       {f(x + half), f(y + half), f(z)},
                       {f(x + half), f(y - half), f(z)}},
                      material);
}
inline hil::Material matt(float base) { return {"matt", base, 0.0F, 1.0F, 0.0F, hil::Pattern::plain, {}}; }
inline hil::Material luminous(float radiance) {
  return {"luminous", 0.0F, 0.0F, 1.0F, radiance, hil::Pattern::plain, {}};
}
inline hil::Mesh one_square(double half, const hil::Material& material) {
  hil::MeshBuilder builder;
  add_square(builder, 0.0, 0.0, 0.0, half, builder.add_material(material));
  return builder.mesh();
}

/// T straight ahead, sun behind the camera, the Earth out of the way.
inline hil::SceneState ahead(double distance) {
  hil::SceneState state;
  state.t_CT = Vec3(0.0, 0.0, distance);
  state.earth_C = Vec3(0.0, 0.0, 1e12);
  return state;
}

inline double level(const hil::Image& image, std::uint32_t u, std::uint32_t v) {
  const std::size_t at = static_cast<std::size_t>(v) * image.width_px + u;
  if (image.bytes_per_pixel == 1) return image.bytes[at];
  std::uint16_t value = 0;
  std::memcpy(&value, image.bytes.data() + 2 * at, 2);
  return value;
}

inline hil::Image rendered(hil::SceneRenderer& renderer, const hil::SceneState& state, double exposure_s = quarter_s,
                           std::uint32_t frame = 0, double gain = 1.0) {
  hil::Image image;
  renderer.render(
      Time{}, frame, exposure_s, gain, [&](Time) { return state; }, image);
  return image;
}

}  // namespace relnav::test
