// From light to levels.
#include <algorithm>

#include "tests/unit/hil_render/scene_case.hpp"

#include <CppUTest/TestHarness.h>

using namespace relnav;
using namespace relnav::hil;
using namespace relnav::test;

namespace {

struct Moments {
  double mean = 0.0;
  double variance = 0.0;
};
/// Over the inner part of an image that shows one surface only.
Moments moments(const Image& image) {
  Moments m;
  double n = 0.0;
  for (std::uint32_t v = 10; v + 10 < image.height_px; ++v) {
    for (std::uint32_t u = 10; u + 10 < image.width_px; ++u) {
      m.mean += level(image, u, v);
      m.variance += level(image, u, v) * level(image, u, v);
      n += 1.0;
    }
  }
  m.mean /= n;
  m.variance = m.variance / n - m.mean * m.mean;
  return m;
}

}  // namespace

TEST_GROUP(RenderSensor) {
  CameraModel camera = camera_of(320, 240, 400.0, false);
  RenderSettings settings = plain_settings();

  /// Nothing but what is luminous.
  static SceneState dark_ahead() {
    SceneState state = ahead(2.0);
    state.sunlight = 0.0;
    return state;
  }
  Image image_of(float radiance, double exposure_s, double gain = 1.0, std::uint64_t seed = 1,
                 std::uint32_t frame = 0) {
    SceneRenderer renderer(settings, camera, nullptr, seed, one_square(3.0, luminous(radiance)));
    return rendered(renderer, dark_ahead(), exposure_s, frame, gain);
  }
};

TEST(RenderSensor, LevelsAreProportionalToExposureAndGain) {
  const double once = moments(image_of(1.0F, quarter_s)).mean;
  DOUBLES_EQUAL(0.25 * 65535.0, once, 40.0);
  DOUBLES_EQUAL(2.0 * once, moments(image_of(1.0F, 2.0 * quarter_s)).mean, 3.0);
  DOUBLES_EQUAL(2.0 * once, moments(image_of(1.0F, quarter_s, 2.0)).mean, 3.0);
  DOUBLES_EQUAL(0.5 * once, moments(image_of(0.5F, quarter_s)).mean, 3.0);
}

TEST(RenderSensor, NoiseIsThatOfCountedElectronsAndOfReading) {
  settings.sensor.noise = true;
  const double per_electron = 65535.0 / settings.sensor.full_well_e;
  for (const double gain : {1.0, 2.0}) {
    for (const double electrons : {0.0, 300.0, 2000.0, 8000.0}) {
      const double exposure_s = std::max(1e-9, electrons / settings.sensor.electrons_per_s);
      settings.sensor.dark_level = 0.1;  // keeps zero from being cut
      const Moments m = moments(image_of(1.0F, exposure_s, gain));
      const double scale = gain * per_electron;
      DOUBLES_EQUAL(electrons * scale + 6553.5, m.mean, 0.02 * scale * std::sqrt(electrons + 625.0) + 1.0);
      const double expected = scale * scale * (electrons + 625.0);
      DOUBLES_EQUAL(1.0, m.variance / expected, 0.03);  // of 66 000 pixels: three sigma are 1.7 %
    }
  }
}

TEST(RenderSensor, NoiseOfTwoFramesIsNotTheSame) {
  settings.sensor.noise = true;
  settings.sensor.dark_level = 0.1;
  const Image a = image_of(1.0F, quarter_s, 1.0, 1, 7);
  const Image b = image_of(1.0F, quarter_s, 1.0, 1, 8);
  double covariance = 0.0;
  const Moments ma = moments(a);
  const Moments mb = moments(b);
  double n = 0.0;
  for (std::uint32_t v = 10; v < 230; ++v) {
    for (std::uint32_t u = 10; u < 310; ++u, n += 1.0) {
      covariance += (level(a, u, v) - ma.mean) * (level(b, u, v) - mb.mean);
    }
  }
  DOUBLES_EQUAL(0.0, covariance / n / std::sqrt(ma.variance * mb.variance), 0.015);
}

TEST(RenderSensor, FullWellsAndHighestLevelsSaturate) {
  settings.sensor.bits = 8;
  settings.sensor.noise = true;
  const Image image = image_of(10.0F, quarter_s);
  DOUBLES_EQUAL(255.0, level(image, 160, 120), 0.0);
  // At half the gain the well is full before the converter is.
  DOUBLES_EQUAL(128.0, level(image_of(10.0F, quarter_s, 0.5), 160, 120), 0.6);
}

TEST(RenderSensor, BitsGoIntoTheUpperEndOfTwoBytes) {
  for (const std::uint32_t bits : {10U, 12U, 16U}) {
    settings.sensor.bits = bits;
    const Image image = image_of(2.0F, quarter_s);
    CHECK_EQUAL(2U, image.bytes_per_pixel);
    DOUBLES_EQUAL(32768.0, level(image, 160, 120), 65536.0 / (1U << bits) + 1.0);
    CHECK_EQUAL(0U, static_cast<std::uint32_t>(level(image, 160, 120)) % (1U << (16U - bits)));
  }
}

TEST(RenderSensor, DeadPixelsSeeNothingAndHotOnesFillInTheDark) {
  settings.sensor.dead_pixels = 40;
  settings.sensor.hot_pixels = 30;
  const Image image = image_of(1.0F, quarter_s);
  int dead = 0;
  for (std::uint32_t v = 0; v < 240; ++v) {
    for (std::uint32_t u = 0; u < 320; ++u) dead += level(image, u, v) < 1.0 ? 1 : 0;
  }
  CHECK(dead >= 38 && dead <= 40);  // two may fall together
  const Image dark = image_of(0.0F, 0.5);
  int hot = 0;
  for (std::uint32_t v = 0; v < 240; ++v) {
    for (std::uint32_t u = 0; u < 320; ++u) hot += level(dark, u, v) > 0.3 * 65535.0 ? 1 : 0;
  }
  CHECK(hot >= 26 && hot <= 30);
  // Another seed, another sensor.
  CHECK_FALSE(image_of(1.0F, quarter_s).bytes == image_of(1.0F, quarter_s, 1.0, 2).bytes);
}

TEST(RenderSensor, TheSameSeedGivesTheSameBytesOnAnyNumberOfThreads) {
  RenderSettings whole;
  whole.sensor.dead_pixels = 10;
  TargetModel lights;
  TargetFeature feature;
  feature.p_T = Vec3(-0.42, -0.40, -0.9);
  CHECK(lights.features.push_back(feature) == Status::ok);
  SceneState state = ahead(3.4);
  state.R_CT = Eigen::AngleAxisd(0.6, Vec3(0.1, 1.0, 0.2).normalized()).toRotationMatrix();
  state.sun_C = Vec3(-0.7, -0.35, -0.62).normalized();
  state.earth_C = Vec3(3e6, 6e6, 1e6);
  const auto image_with = [&](std::uint32_t threads, std::uint64_t seed, std::uint32_t frame) {
    whole.threads = threads;
    SceneRenderer renderer(whole, camera, &lights, seed);
    rendered(renderer, state, 1e-3, 99);  // what was before must not matter
    return rendered(renderer, state, 1e-3, frame).bytes;
  };
  const auto first = image_with(1, 5, 3);
  CHECK(first == image_with(1, 5, 3));
  CHECK(first == image_with(2, 5, 3));
  CHECK(first == image_with(5, 5, 3));
  CHECK_FALSE(first == image_with(2, 6, 3));
  CHECK_FALSE(first == image_with(2, 5, 4));
}

TEST(RenderSensor, ThePointSpreadKeepsTheLightAndTheHaloReachesFar) {
  settings.spread.sigma_px = 1.2;
  SceneRenderer sharp(settings, camera, nullptr, 1, one_square(0.02, luminous(1.0F)));
  settings.spread.halo_share = 0.05;
  settings.spread.halo_sigma_px = 8.0;
  SceneRenderer hazy(settings, camera, nullptr, 1, one_square(0.02, luminous(1.0F)));
  const auto sum_and_spread = [](const Image& image, double& sum, double& variance) {
    double su = 0.0;
    double suu = 0.0;
    sum = 0.0;
    for (std::uint32_t v = 0; v < image.height_px; ++v) {
      for (std::uint32_t u = 0; u < image.width_px; ++u) {
        const double l = level(image, u, v);
        sum += l;
        su += l * u;
        suu += l * u * u;
      }
    }
    variance = suu / sum - su * su / sum / sum;
  };
  double sum = 0.0;
  double variance = 0.0;
  sum_and_spread(rendered(sharp, dark_ahead(), 3.0 * quarter_s), sum, variance);
  // The square is 8 px wide: variance 64 / 12, that of the core and that of a pixel.
  DOUBLES_EQUAL(64.0 / 12.0 + 1.44, variance, 0.25);
  double hazy_sum = 0.0;
  double hazy_variance = 0.0;
  sum_and_spread(rendered(hazy, dark_ahead(), 3.0 * quarter_s), hazy_sum, hazy_variance);
  DOUBLES_EQUAL(1.0, hazy_sum / sum, 0.01);
  DOUBLES_EQUAL(0.05 * (64.0 - 1.44), hazy_variance - variance, 0.35);
}
