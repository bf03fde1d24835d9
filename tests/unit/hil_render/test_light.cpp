// Sun, shadows, Earth.
#include "hil/render/sky.hpp"
#include "tests/unit/hil_render/scene_case.hpp"

#include <CppUTest/TestHarness.h>

using namespace relnav;
using namespace relnav::hil;
using namespace relnav::test;

TEST_GROUP(RenderLight) {
  CameraModel camera = camera_of(160, 120, 200.0, false);
  static constexpr std::uint32_t u_mid = 82;
  static constexpr std::uint32_t v_mid = 56;

  double middle(const Material& material, const SceneState& state, RenderSettings settings = plain_settings()) {
    SceneRenderer renderer(settings, camera, nullptr, 1, one_square(0.5, material));
    return level(rendered(renderer, state), u_mid, v_mid) / 65535.0;
  }
};

TEST(RenderLight, AWhiteMattSurfaceInFullSunHasRadianceOneAndFollowsTheCosine) {
  const double straight = middle(matt(0.5F), ahead(2.0));
  // 4 % of the light are mirrored off before, and some of that comes back to the camera.
  DOUBLES_EQUAL(0.25 * 0.5, straight, 0.25 * 0.5 * 0.06);
  SceneState slanted = ahead(2.0);
  slanted.sun_C = Vec3(std::sqrt(0.75), 0.0, -0.5);
  DOUBLES_EQUAL(0.5, middle(matt(0.5F), slanted) / straight, 0.03);
  SceneState behind = ahead(2.0);
  behind.sun_C = Vec3(0.0, 0.0, 1.0);
  DOUBLES_EQUAL(0.0, middle(matt(0.5F), behind), 1e-5);
}

TEST(RenderLight, AMetalMirrorsTheSunIntoOneDirectionOnly) {
  const Material mirror{"mirror", 0.9F, 1.0F, 0.3F, 0.0F, Pattern::plain, {}};
  const double straight = middle(mirror, ahead(2.0));
  SceneState slanted = ahead(2.0);
  slanted.sun_C = Vec3(std::sqrt(0.75), 0.0, -0.5);
  CHECK(straight > 0.99);  // saturated
  CHECK(middle(mirror, slanted) < 0.01);
}

TEST(RenderLight, WhatStandsInTheWayOfTheSunThrowsAShadowAsSoftAsTheSunIsWide) {
  MeshBuilder builder;
  const std::uint32_t white = builder.add_material(matt(0.8F));
  add_square(builder, 0.0, 0.0, 0.0, 0.6, white);
  add_square(builder, -1.1, 0.0, -1.0, 0.5, white);
  RenderSettings settings = plain_settings();
  settings.edge_samples = 64;
  settings.spread.sigma_px = 0.3;
  const CameraModel close = camera_of(640, 480, 900.0, false);
  SceneRenderer renderer(settings, close, nullptr, 1, builder.mesh());
  SceneState state = ahead(2.5);
  state.sun_C = Vec3(-1.0, 0.0, -1.0).normalized();  // the shadow's edge: x = -0.6 + 1 = 0.4
  const Image image = rendered(renderer, state);
  Vec2 edge;
  CHECK(close.project(Vec3(0.4, 0.0, 2.5), edge) == Status::ok);
  const auto u = static_cast<std::uint32_t>(std::lround(edge.x()));
  const auto v = static_cast<std::uint32_t>(std::lround(edge.y()));
  const double sunny = level(image, u + 15, v);
  DOUBLES_EQUAL(0.0, level(image, u - 15, v), 1.0);
  CHECK(sunny > 5000.0);
  // Where it is half: the centre of the sun. Penumbra: sqrt(2) m of way, 0.533 deg, on a surface turned by 45 deg.
  double lit = 0.0;
  double soft = 0.0;
  for (std::uint32_t k = u - 15; k <= u + 15; ++k) {
    lit += level(image, k, v) / sunny;
    const double share = level(image, k, v) / sunny;
    soft += share > 0.05 && share < 0.95 ? 1.0 : 0.0;
  }
  DOUBLES_EQUAL(edge.x(), u + 15.5 - lit, 0.25);
  const double penumbra_px = 900.0 / 2.5 * std::sqrt(2.0) * std::sqrt(2.0) * 2.0 * sun_radius_rad;
  DOUBLES_EQUAL(penumbra_px, soft, 0.45 * penumbra_px);
}

TEST(RenderLight, TheEarthLightsWhatTheSunDoesNot) {
  SceneState night_side = ahead(2.0);
  night_side.sun_C = Vec3(0.0, 0.0, 1.0);
  night_side.earth_C = Vec3(0.0, 0.0, -6.8e6);  // full, behind the camera
  const double lit = middle(matt(0.8F), night_side);
  // Irradiance of a uniform disc straight ahead: pi L sin^2; L of a Lambert Earth at full phase is 0.2 .. 0.3.
  const double sine = earth_radius / 6.8e6;
  CHECK(lit > 0.25 * 0.8 * 0.15 * sine * sine);
  CHECK(lit < 0.25 * 0.8 * 0.30 * sine * sine + 0.25 * 0.04 * 0.30);  // and what is mirrored
  night_side.earth_C = Vec3(0.0, 0.0, 6.8e6);                         // behind the target, and dark
  DOUBLES_EQUAL(0.0, middle(matt(0.8F), night_side), 1e-5);
  night_side.earth_C = Vec3(0.0, 0.0, -6.8e6);
  RenderSettings black_earth = plain_settings();
  black_earth.earth_albedo = 0.0;
  DOUBLES_EQUAL(0.0, middle(matt(0.8F), night_side, black_earth), 1e-5);
}

TEST(RenderLight, InEclipseOnlyTheLightsAreSeen) {
  TargetModel lights;
  TargetFeature feature;
  feature.p_T = Vec3(0.3, 0.0, -0.1);
  CHECK(lights.features.push_back(feature) == Status::ok);
  SceneRenderer renderer(plain_settings(), camera, &lights, 1, one_square(0.5, matt(0.8F)));
  SceneState state = ahead(2.0);
  const double day = level(rendered(renderer, state), u_mid - 20, v_mid);
  state.sunlight = 0.5;
  DOUBLES_EQUAL(0.5 * day, level(rendered(renderer, state), u_mid - 20, v_mid), 1.0);
  state.sunlight = 0.0;
  const Image image = rendered(renderer, state);
  DOUBLES_EQUAL(0.0, level(image, u_mid - 20, v_mid), 1.0);
  Vec2 at;
  CHECK(camera.project(Vec3(0.3, 0.0, 1.9), at) == Status::ok);
  CHECK(level(image, static_cast<std::uint32_t>(at.x()), static_cast<std::uint32_t>(at.y())) > 20'000.0);
}

TEST(RenderLight, TheEarthsDiscHidesStarsAndHasItsLimbWhereGeometrySays) {
  SceneState state = ahead(1000.0);
  state.earth_C = Vec3(0.0, 7e6, 5e6);
  state.sun_C = Vec3(0.0, -1.0, -0.3).normalized();
  RenderSettings settings = plain_settings();
  settings.earth = true;
  SceneRenderer renderer(settings, camera, nullptr, 1, one_square(0.001, matt(0.0F)));
  const Image image = rendered(renderer, state, 2.0 * quarter_s);
  // Straight down the middle column: the limb is seen earth_radius off the centre's direction.
  const double centre = std::atan2(7.0, 5.0);
  const double radius = std::asin(earth_radius / state.earth_C.norm());
  const double limb_v = camera.intrinsics().cv + camera.intrinsics().fv * std::tan(centre - radius);
  const auto row = static_cast<std::uint32_t>(std::lround(limb_v));
  CHECK(row > 20 && row < 110);
  CHECK(level(image, u_mid, row + 3) > 1000.0);
  CHECK(level(image, u_mid, row - 4) < 0.05 * level(image, u_mid, row + 3));
  const Sky sky(state, 0.3, true);
  CHECK(sky.hides_stars(normalized(to_float(state.earth_C))));
  CHECK_FALSE(sky.hides_stars({0.0F, 0.0F, 1.0F}));
}

TEST(RenderLight, StarsAreFixedInInertialSpaceAndComeOutWithLongExposures) {
  RenderSettings settings = plain_settings();
  settings.stars = true;
  SceneRenderer renderer(settings, camera, nullptr, 1, one_square(0.001, matt(0.0F)));
  const Star& star = star_catalogue().front();
  SceneState state = ahead(50.0);
  state.sunlight = 0.0;
  // Its direction becomes one in the upper half of the image.
  const Vec3 to_C = Vec3(0.1, -0.12, 1.0).normalized();
  state.R_CI = Eigen::Quaterniond::FromTwoVectors(star.direction_I, to_C).toRotationMatrix();
  Vec2 at;
  CHECK(camera.project(to_C, at) == Status::ok);
  const auto u = static_cast<std::uint32_t>(std::lround(at.x()));
  const auto v = static_cast<std::uint32_t>(std::lround(at.y()));
  const double exposure_s = 1.0;
  CHECK(level(rendered(renderer, state, exposure_s), u, v) > 20.0);
  DOUBLES_EQUAL(0.0, level(rendered(renderer, state, 1e-4), u, v), 0.5);
}
