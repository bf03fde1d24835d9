#include "hil/render/render_settings.hpp"

#include <cmath>
#include <numbers>

namespace relnav::hil {
namespace {

constexpr Words<bool, 2> yes_no{{{"true", true}, {"false", false}}};

Vec3 three_numbers(const FileSection& section, const char* key, const char* expectation) {
  if (!section.has(key)) return Vec3::Zero();
  const YAML::Node list = section.node(key);
  if (!list.IsSequence() || list.size() != 3)
    section.fail(list, std::string(key) + " is no list of three", expectation);
  Vec3 values;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto value = list[i].IsScalar() ? parse_double(list[i].Scalar()) : std::nullopt;
    if (!value || !std::isfinite(*value))
      section.fail(list[i], std::string(key) + " holds what is no number", expectation);
    values(static_cast<Eigen::Index>(i)) = *value;
  }
  return values;
}

Mat3 turned(Eigen::Index axis, double degrees) {
  const double angle = degrees * std::numbers::pi / 180.0;
  const Eigen::Index a = (axis + 1) % 3;
  const Eigen::Index b = (axis + 2) % 3;
  Mat3 R_turn = Mat3::Identity();
  R_turn(a, a) = R_turn(b, b) = std::cos(angle);
  R_turn(b, a) = std::sin(angle);
  R_turn(a, b) = -R_turn(b, a);
  return R_turn;
}

}  // namespace

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
  const Vec3 angles = three_numbers(section, "mesh_rotation_deg", "degrees about x, y, z");
  s.placement.R_TM = turned(2, angles.z()) * turned(1, angles.y()) * turned(0, angles.x());
  s.placement.offset_T = three_numbers(section, "mesh_offset", "metres along x, y, z of T");

  s.threads = whole("threads", 1, 64, s.threads);
  s.edge_samples = whole("edge_samples", 4, 64, s.edge_samples);
  if (s.edge_samples != 4 && s.edge_samples % 8 != 0)
    section.fail(section.node("edge_samples"), "edge_samples is neither 4 nor a multiple of 8", "4, 8, 16, 24 ...");
  s.motion_blur = whole("motion_blur", 1, 32, s.motion_blur);
  s.row_time_us = section.number_or("row_time_us", 0.0, 1000.0, s.row_time_us);

  s.light_radiance = section.number_or("light_radiance", 0.0, 1e4, s.light_radiance);
  s.earth_albedo = section.number_or("earth_albedo", 0.0, 1.0, s.earth_albedo);
  s.fill = section.number_or("fill", 0.0, 1.0, s.fill);
  s.earth = section.word_or("earth", yes_no, s.earth);
  s.stars = section.word_or("stars", yes_no, s.stars);
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
  c.noise = section.word_or("noise", yes_no, c.noise);
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
