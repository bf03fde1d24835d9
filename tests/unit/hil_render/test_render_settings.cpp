// Section `render`.
#include "hil/render/render_settings.hpp"
#include "tests/support/yaml_tables.hpp"

#include <CppUTest/TestHarness.h>

using namespace relnav;
using namespace relnav::hil;

namespace {

RenderSettings read(const std::string& text) {
  return read_render_settings(FileSection("/a/b.yaml", YAML::Load(text), "render", render_keys()));
}
std::string error_of(const std::string& text) {
  try {
    static_cast<void>(read(text));
  } catch (const InputError& error) {
    return error.what();
  }
  return {};
}

}  // namespace

TEST_GROUP(RenderSettingsFile){void check_error(const std::string& text, const char* place,
                                                const char* word){const std::string error = error_of(text);
CHECK_TEXT(error.find(place) == 0, error.c_str());
CHECK_TEXT(error.find(word) != std::string::npos, error.c_str());
}
}
;

TEST(RenderSettingsFile, EveryKeyMayBeLeftOut) {
  const RenderSettings s = read("{}");
  CHECK(s.mesh.empty());
  CHECK_EQUAL(2U, s.threads);
  CHECK_EQUAL(8U, s.sensor.bits);
  CHECK(s.sensor.noise);
}

TEST(RenderSettingsFile, KeysAreRead) {
  const RenderSettings s = read(
      "mesh: sat.glb\nmesh_scale: 0.001\nmesh_rotation_deg: [90, 0, 0]\nmesh_offset: [1, 2, 3]\nthreads: 1\n"
      "edge_samples: 16\nmotion_blur: 4\nrow_time_us: 20\nlight_radiance: 2\nearth_albedo: 0.4\nfill: 0.01\nearth: "
      "false\n"
      "stars: false\nstar_brightness: 5\npsf_sigma_px: 0.9\nhalo_share: 0.02\nhalo_sigma_px: 7\nelectrons_per_s: 1e6\n"
      "full_well_e: 9000\nread_noise_e: 8\ndark_current_e_s: 3\ndark_level: 0.02\nnoise: false\nresponse_sd: 0.01\n"
      "dead_pixels: 3\nhot_pixels: 4\nbits: 12\n");
  STRCMP_EQUAL("/a/sat.glb", s.mesh.c_str());
  DOUBLES_EQUAL(0.001, s.placement.scale, 0.0);
  CHECK((s.placement.R_TM * Vec3(0.0, 1.0, 0.0) - Vec3(0.0, 0.0, 1.0)).norm() < 1e-12);
  CHECK((s.placement.offset_T - Vec3(1.0, 2.0, 3.0)).norm() < 1e-12);
  CHECK_EQUAL(1U, s.threads);
  CHECK_EQUAL(16U, s.edge_samples);
  CHECK_EQUAL(4U, s.motion_blur);
  DOUBLES_EQUAL(20.0, s.row_time_us, 0.0);
  DOUBLES_EQUAL(2.0, s.light_radiance, 0.0);
  DOUBLES_EQUAL(0.4, s.earth_albedo, 0.0);
  DOUBLES_EQUAL(0.01, s.fill, 0.0);
  CHECK_FALSE(s.earth);
  CHECK_FALSE(s.stars);
  DOUBLES_EQUAL(5.0, s.star_brightness, 0.0);
  DOUBLES_EQUAL(0.9, s.spread.sigma_px, 0.0);
  DOUBLES_EQUAL(0.02, s.spread.halo_share, 0.0);
  DOUBLES_EQUAL(7.0, s.spread.halo_sigma_px, 0.0);
  DOUBLES_EQUAL(1e6, s.sensor.electrons_per_s, 0.0);
  DOUBLES_EQUAL(9000.0, s.sensor.full_well_e, 0.0);
  DOUBLES_EQUAL(8.0, s.sensor.read_noise_e, 0.0);
  DOUBLES_EQUAL(3.0, s.sensor.dark_current_e_s, 0.0);
  DOUBLES_EQUAL(0.02, s.sensor.dark_level, 0.0);
  CHECK_FALSE(s.sensor.noise);
  DOUBLES_EQUAL(0.01, s.sensor.response_sd, 0.0);
  CHECK_EQUAL(3U, s.sensor.dead_pixels);
  CHECK_EQUAL(4U, s.sensor.hot_pixels);
  CHECK_EQUAL(12U, s.sensor.bits);
}

TEST(RenderSettingsFile, MistakesAreNamedWithTheirLine) {
  check_error("fill: 0\nblur: 3\n", "/a/b.yaml:2:", "render.blur");
  check_error("edge_samples: 12\n", "/a/b.yaml:1:", "edge_samples");
  check_error("noise: maybe\n", "/a/b.yaml:1:", "noise");
  check_error("bits: 9\n", "/a/b.yaml:1:", "bits");
  check_error("mesh_offset: [1, 2]\n", "/a/b.yaml:1:", "mesh_offset");
  check_error("mesh_rotation_deg: [1, x, 2]\n", "/a/b.yaml:1:", "mesh_rotation_deg");
  check_error("psf_sigma_px: 0\n", "/a/b.yaml:1:", "psf_sigma_px");
}
