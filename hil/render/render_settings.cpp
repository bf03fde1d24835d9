#include "hil/render/render_settings.hpp"

#include <cmath>
#include "hil/dynamics/turning.hpp"

namespace relnav::hil {
namespace {}  // namespace

std::vector<std::string> render_keys() {
  return {"mesh",
          "mesh_scale",
          "mesh_rotation_deg",
          "mesh_offset",
          "threads",
          "edge_samples",
          "motion_blur",
          "row_time_us",
          "light_radiance",
          "earth_albedo",
          "fill",
          "earth",
          "stars",
          "star_brightness",
          "psf_sigma_px",
          "halo_share",
          "halo_sigma_px",
          "electrons_per_s",
          "full_well_e",
          "read_noise_e",
          "dark_current_e_s",
          "dark_level",
          "noise",
          "response_sd",
          "dead_pixels",
          "hot_pixels",
          "bits"};
}

RenderSettings read_render_settings(const FileSection& section) {
  RenderSettings s;
  const auto whole = [&](const char* key, std::int64_t low, std::int64_t high, std::uint32_t fallback) {
    return static_cast<std::uint32_t>(section.whole_or(key, low, high, fallback));
  };
  if (section.has("mesh")) s.mesh = section.file("mesh", "the path of a mesh, from this file");
  s.placement.scale = section.number_or("mesh_scale", 1e-6, 1e6, s.placement.scale);
  s.placement.R_TM = rotation_of_angles(section.three_or("mesh_rotation_deg", 360.0, Vec3::Zero()));
  s.placement.offset_T = section.three_or("mesh_offset", 1e6, Vec3::Zero());

  s.threads = whole("threads", 1, 64, s.threads);
  s.edge_samples = whole("edge_samples", 4, 64, s.edge_samples);
  if (s.edge_samples != 4 && s.edge_samples % 8 != 0)
    section.fail(section.node("edge_samples"), "edge_samples is neither 4 nor a multiple of 8", "4, 8, 16, 24 ...");
  s.motion_blur = whole("motion_blur", 1, 32, s.motion_blur);
  s.row_time_us = section.number_or("row_time_us", 0.0, 1000.0, s.row_time_us);

  s.light_radiance = section.number_or("light_radiance", 0.0, 1e4, s.light_radiance);
  s.earth_albedo = section.number_or("earth_albedo", 0.0, 1.0, s.earth_albedo);
  s.fill = section.number_or("fill", 0.0, 1.0, s.fill);
  s.earth = section.yes_no_or("earth", s.earth);
  s.stars = section.yes_no_or("stars", s.stars);
  s.star_brightness = section.number_or("star_brightness", 0.0, 1e9, s.star_brightness);

  s.spread.sigma_px = section.number_or("psf_sigma_px", 0.3, 5.0, s.spread.sigma_px);
  s.spread.halo_share = section.number_or("halo_share", 0.0, 0.5, s.spread.halo_share);
  s.spread.halo_sigma_px = section.number_or("halo_sigma_px", 3.0, 60.0, s.spread.halo_sigma_px);

  SensorSettings& c = s.sensor;
  c.electrons_per_s = section.number_or("electrons_per_s", 1.0, 1e12, c.electrons_per_s);
  c.full_well_e = section.number_or("full_well_e", 100.0, 1e7, c.full_well_e);
  c.read_noise_e = section.number_or("read_noise_e", 0.0, 1e4, c.read_noise_e);
  c.dark_current_e_s = section.number_or("dark_current_e_s", 0.0, 1e7, c.dark_current_e_s);
  c.dark_level = section.number_or("dark_level", 0.0, 0.5, c.dark_level);
  c.noise = section.yes_no_or("noise", c.noise);
  c.response_sd = section.number_or("response_sd", 0.0, 0.2, c.response_sd);
  c.dead_pixels = whole("dead_pixels", 0, 100'000, c.dead_pixels);
  c.hot_pixels = whole("hot_pixels", 0, 100'000, c.hot_pixels);
  if (section.has("bits")) {
    static constexpr Words<std::uint32_t, 4> depths{{{"8", 8}, {"10", 10}, {"12", 12}, {"16", 16}}};
    c.bits = section.word("bits", depths);
  }
  return s;
}

}  // namespace relnav::hil
