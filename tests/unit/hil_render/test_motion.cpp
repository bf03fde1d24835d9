// What moves while the shutter is open.
#include "tests/unit/hil_render/scene_case.hpp"

#include <CppUTest/TestHarness.h>

using namespace relnav;
using namespace relnav::hil;
using namespace relnav::test;

TEST_GROUP(RenderMotion) {
  CameraModel camera = camera_of(320, 240, 400.0, false);
  RenderSettings settings = plain_settings();
  static constexpr double speed = 10.0;  // m/s to the right: 2000 px/s at 2 m

  Image moving(const Mesh& mesh, double exposure_s, const TargetModel* lights = nullptr) {
    SceneRenderer renderer(settings, camera, lights, 1, mesh);
    Image image;
    const auto state_at = [](Time t) {
      SceneState state = ahead(2.0);
      state.time = t;
      state.t_CT.x() = speed * static_cast<double>(t.ns) * 1e-9;
      return state;
    };
    renderer.render(Time{}, 0, exposure_s, 1.0, state_at, image);
    return image;
  }
  static double variance_u(const Image& image, std::uint32_t v) {
    const double mean = centroid_u(image, v);
    double sum = 0.0;
    double weight = 0.0;
    for (std::uint32_t u = 0; u < image.width_px; ++u) {
      sum += level(image, u, v) * (u - mean) * (u - mean);
      weight += level(image, u, v);
    }
    return sum / weight;
  }
  static double centroid_u(const Image& image, std::uint32_t v) {
    double sum = 0.0;
    double weight = 0.0;
    for (std::uint32_t u = 0; u < image.width_px; ++u) {
      sum += level(image, u, v) * u;
      weight += level(image, u, v);
    }
    return sum / weight;
  }
};

TEST(RenderMotion, BlurIsAsLongAsTheMotionAndKeepsTheMiddle) {
  const double exposure_s = 5e-3;  // 10 px
  const Mesh mesh = one_square(0.05, luminous(0.05F));
  const Image still = moving(mesh, exposure_s);
  settings.motion_blur = 32;
  const Image blurred = moving(mesh, exposure_s);
  const auto v = static_cast<std::uint32_t>(std::lround(camera.intrinsics().cv));
  DOUBLES_EQUAL(10.0 * 10.0 / 12.0, variance_u(blurred, v) - variance_u(still, v), 0.3);  // of a smear of 10 px
  DOUBLES_EQUAL(centroid_u(still, v), centroid_u(blurred, v), 0.05);
  DOUBLES_EQUAL(camera.intrinsics().cu, centroid_u(blurred, v), 0.05);
}

TEST(RenderMotion, LightsAreBlurredToo) {
  TargetModel lights;
  CHECK(lights.features.push_back(TargetFeature{}) == Status::ok);
  MeshBuilder builder;
  add_square(builder, 0.0, 0.0, 9.0, 0.001, builder.add_material(matt(0.0F)));
  settings.light_radiance = 0.05;
  settings.motion_blur = 32;
  const Image blurred = moving(builder.mesh(), 5e-3, &lights);
  settings.motion_blur = 1;
  const Image still = moving(builder.mesh(), 5e-3, &lights);
  const auto v = static_cast<std::uint32_t>(std::lround(camera.intrinsics().cv));
  DOUBLES_EQUAL(10.0 * 10.0 / 12.0, variance_u(blurred, v) - variance_u(still, v), 0.3);  // of a smear of 10 px
}

TEST(RenderMotion, WhatStandsStillIsNotBlurred) {
  settings.motion_blur = 32;
  SceneRenderer with(settings, camera, nullptr, 1, one_square(0.3, luminous(0.5F)));
  settings.motion_blur = 1;
  SceneRenderer without(settings, camera, nullptr, 1, one_square(0.3, luminous(0.5F)));
  CHECK(rendered(with, ahead(2.0)).bytes == rendered(without, ahead(2.0)).bytes);
}

TEST(RenderMotion, ARollingShutterLeansWhatMoves) {
  settings.row_time_us = 50.0;  // 0.1 px a row
  TargetModel lights;
  for (const double y : {-0.5, 0.5}) {
    TargetFeature feature;
    feature.p_T = Vec3(0.3, y, 0.0);
    CHECK(lights.features.push_back(feature) == Status::ok);
  }
  MeshBuilder builder;
  const std::uint32_t material = builder.add_material(luminous(1.0F));
  const auto bar = [](double x, double y) { return Vec3f{static_cast<float>(x), static_cast<float>(y), 0.0F}; };
  builder.add_polygon({bar(-0.05, -0.5), bar(-0.05, 0.5), bar(0.05, 0.5), bar(0.05, -0.5)}, material);
  settings.light_radiance = 0.0;
  const Image image = moving(builder.mesh(), quarter_s, &lights);
  DOUBLES_EQUAL(0.1 * 120.0, centroid_u(image, 180) - centroid_u(image, 60), 0.05);
  // The row in the middle has the stamp's time.
  DOUBLES_EQUAL(camera.intrinsics().cu, 0.5 * (centroid_u(image, 119) + centroid_u(image, 120)), 0.05);

  settings.light_radiance = 1.0;
  MeshBuilder nothing;
  add_square(nothing, 0.0, 0.0, 9.0, 0.001, nothing.add_material(matt(0.0F)));
  const Image spots = moving(nothing.mesh(), quarter_s, &lights);
  double u_of[2];
  for (int i = 0; i < 2; ++i) {
    double sum = 0.0;
    double weight = 0.0;
    for (std::uint32_t v = i == 0 ? 0U : 120U; v < (i == 0 ? 120U : 240U); ++v) {
      for (std::uint32_t u = 0; u < 320; ++u) {
        sum += u * level(spots, u, v);
        weight += level(spots, u, v);
      }
    }
    u_of[i] = sum / weight;
  }
  DOUBLES_EQUAL(0.1 * 400.0 * 1.002 * 0.5, u_of[1] - u_of[0], 0.05);
}
