#include "fsw/vision/light_spot_finder.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

#include "tests/support/campaign.hpp"
#include "tests/support/lamp_scene.hpp"
#include "tests/unit/vision/test_images.hpp"

#include <CppUTest/TestHarness.h>

namespace relnav::vision {
namespace {

constexpr int phases = relnav::test::campaign(100, 25);  // of a spot within a pixel

using test::Lamp;
using test::view_of;
using Scene = test::LampScene;

/// Spot nearest to (u, v) within 2 px, or null.
const LightSpot* nearest(const LightSpots& spots, double u, double v) {
  const LightSpot* best = nullptr;
  double distance = 2.0;
  for (const LightSpot& spot : spots) {
    const double here = std::hypot(spot.uv_px(0) - u, spot.uv_px(1) - v);
    if (here < distance) {
      distance = here;
      best = &spot;
    }
  }
  return best;
}

struct Errors {
  double bias_u_px = 0.0;
  double bias_v_px = 0.0;
  double largest_px = 0.0;  // of a coordinate
  double rms_px = 0.0;      // a coordinate
  double normalised = 0.0;  // rms of error / sigma
};

}  // namespace

TEST_GROUP(LightSpotFinder) {
  std::unique_ptr<LightSpotFinder> finder = std::make_unique<LightSpotFinder>();
  SpotSettings settings;
  LightSpots spots;
  SpotReport report;

  void setup() override {
    settings.gain_electrons_dn = test::lamp_gain;
    settings.read_noise_dn = test::lamp_read_noise;
    configure();
  }
  void configure() { CHECK(finder->configure(settings) == Status::ok); }

  void find(const Scene& scene, const std::vector<std::uint8_t>& pixels) {
    CHECK(finder->find(view_of(scene, pixels), spots, report) == Status::ok);
  }

  /// Spots at `count` sub-pixel positions; with noise when there is a seed.
  Errors measure(double radius, double amplitude, double background, int count, std::uint64_t seed) {
    Errors errors;
    Generator phase(17);
    relnav::test::Normal noise(seed);
    double squares = 0.0;
    double normalised = 0.0;
    for (int i = 0; i < count; ++i) {
      Scene scene(48, 48, background);
      const Lamp lamp{23.0 + phase.uniform(), 24.0 + phase.uniform(), radius, amplitude};
      scene.add(lamp);
      find(scene, scene.expose<std::uint8_t>(seed != 0 ? &noise : nullptr));
      const LightSpot* spot = nearest(spots, lamp.u, lamp.v);
      CHECK(spot != nullptr);
      if (spot == nullptr) return errors;
      const double eu = spot->uv_px(0) - lamp.u;
      const double ev = spot->uv_px(1) - lamp.v;
      errors.bias_u_px += eu / count;
      errors.bias_v_px += ev / count;
      errors.largest_px = std::max({errors.largest_px, std::fabs(eu), std::fabs(ev)});
      squares += eu * eu + ev * ev;
      normalised += (eu * eu + ev * ev) / (spot->sigma_px * spot->sigma_px);
    }
    errors.rms_px = std::sqrt(squares / (2.0 * count));
    errors.normalised = std::sqrt(normalised / (2.0 * count));
    return errors;
  }
};

TEST(LightSpotFinder, UnsaturatedSpotsAreUnbiasedAtEverySubpixelPhase) {
  for (const double radius : {0.0, 1.0, 2.0, 4.0, 6.5}) {
    const Errors errors = measure(radius, 200.0, 3.0, phases, 0);
    CHECK(errors.largest_px < 0.01);
  }
}

TEST(LightSpotFinder, SaturatedSpotsAreHardlyBiased) {
  for (const double amplitude : {400.0, 1000.0, 2000.0}) {
    for (const double radius : {0.0, 1.5, 3.0, 6.0}) {
      const Errors errors = measure(radius, amplitude, 3.0, phases, 0);
      CHECK(errors.largest_px < 0.02);
      CHECK(std::fabs(errors.bias_u_px) < 0.003);
      CHECK(std::fabs(errors.bias_v_px) < 0.003);
      CHECK(spots[0].saturated_px > 0);
    }
  }
}

TEST(LightSpotFinder, SpotsBlurredByMotionKeepTheirMiddle) {
  // A round spot settles on one end of a path: up to 0.7 px off where it is found at all.
  Generator phase(23);
  for (const double path_px : {1.0, 2.0, 4.0, 7.0}) {
    for (const double amplitude : {150.0, 1000.0, 4000.0}) {
      for (const double radius : {0.0, 1.5}) {
        constexpr int count = 12;
        double squares = 0.0;
        for (int i = 0; i < count; ++i) {
          const double angle = std::numbers::pi * phase.uniform();
          const Lamp lamp{31.0 + phase.uniform(),    32.0 + phase.uniform(),   radius, amplitude,
                          path_px * std::cos(angle), path_px * std::sin(angle)};
          Scene scene(64, 64, 3.0);
          scene.add(lamp);
          find(scene, scene.expose<std::uint8_t>(nullptr));
          const LightSpot* spot = nearest(spots, lamp.u, lamp.v);
          CHECK(spot != nullptr);
          if (spot == nullptr) return;
          squares += (spot->uv_px - Vec2(lamp.u, lamp.v)).squaredNorm();
        }
        // Both coordinates together. Some of the points on a long path are still taken for round.
        CHECK(std::sqrt(squares / count) < (radius > 0.0 ? 0.1 : 0.3));
      }
    }
  }
}

TEST(LightSpotFinder, SigmaIsHonestUnderTheCamerasNoise) {
  settings.sigma_floor_px = 0.0;
  settings.gain_electrons_dn = test::lamp_gain;
  configure();
  // Larger and brighter ones: what the profile does not explain is stated on top.
  for (const double radius : {0.0, 1.5}) {
    for (const double amplitude : {90.0, 200.0}) {
      const Errors errors = measure(radius, amplitude, 10.0, 300, 5);
      CHECK(errors.normalised > 0.8);
      CHECK(errors.normalised < 1.25);
    }
  }
}

TEST(LightSpotFinder, SaturationAndNeighboursIncreaseSigma) {
  const auto sigma_of = [&](double full_scale, bool neighbour) {
    settings.full_scale_dn = full_scale;
    configure();
    Scene scene(48, 48, 3.0);
    scene.add({23.7, 24.2, 0.0, 900.0});
    if (neighbour) scene.add({26.4, 24.9, 0.0, 250.0});
    const std::vector<std::uint16_t> pixels = scene.expose<std::uint16_t>(nullptr, 1.0, full_scale);
    CHECK(finder->find(view_of(scene, pixels), spots, report) == Status::ok);
    const LightSpot* spot = nearest(spots, 23.7, 24.2);
    return spot != nullptr ? spot->sigma_px : 0.0;
  };
  settings.sigma_floor_px = 0.0;
  const double plain = sigma_of(1023.0, false);
  CHECK(plain > 0.0);
  CHECK(sigma_of(255.0, false) > 1.2 * plain);
  CHECK(sigma_of(1023.0, true) > 2.0 * plain);
}

TEST(LightSpotFinder, NeighbouringGlintPullsLittle) {
  for (const double amplitude : {200.0, 800.0}) {
    for (int i = 0; i < 24; ++i) {
      const double angle = 2.0 * std::numbers::pi * i / 24.0;
      Scene scene(64, 64, 3.0);
      scene.add({31.3, 31.8, 1.5, amplitude});
      scene.add({31.3 + 6.0 * std::cos(angle), 31.8 + 6.0 * std::sin(angle), 0.0, 150.0});
      find(scene, scene.expose<std::uint8_t>(nullptr));
      const LightSpot* spot = nearest(spots, 31.3, 31.8);
      CHECK(spot != nullptr);
      if (spot == nullptr) return;
      CHECK(std::hypot(spot->uv_px(0) - 31.3, spot->uv_px(1) - 31.8) < 0.03);
      CHECK_EQUAL(2U, spots.size());
    }
  }
}

TEST(LightSpotFinder, SpotBeforeABrightSurfaceIsFound) {
  Scene scene(160, 160, 2.0);
  for (int v = 0; v < 160; ++v) {
    for (int u = 70; u < 160; ++u) scene.at(u, v) = 140.0 + 10.0 * ((u / 3 + v / 5) % 2);
  }
  scene.add({110.3, 90.6, 2.0, 300.0});  // on the surface
  scene.add({30.8, 60.2, 1.0, 120.0});   // on black
  find(scene, scene.expose<std::uint8_t>(nullptr));
  const LightSpot* on_surface = nearest(spots, 110.3, 90.6);
  const LightSpot* on_black = nearest(spots, 30.8, 60.2);
  CHECK(on_surface != nullptr);
  CHECK(on_black != nullptr);
  if (on_surface == nullptr || on_black == nullptr) return;
  CHECK(std::hypot(on_surface->uv_px(0) - 110.3, on_surface->uv_px(1) - 90.6) < 0.1);
  CHECK(std::hypot(on_black->uv_px(0) - 30.8, on_black->uv_px(1) - 60.2) < 0.02);
}

TEST(LightSpotFinder, SixteenBitsGiveWhatEightScaledGive) {
  Scene scene(200, 120, 4.0);
  Generator positions(3);
  for (int i = 0; i < 12; ++i) {
    scene.add({10.0 + 180.0 * positions.uniform(), 10.0 + 100.0 * positions.uniform(), 0.3 * i, 100.0 + 60.0 * i});
  }
  relnav::test::Normal noise(8);
  relnav::test::Normal same_noise(8);
  find(scene, scene.expose<std::uint8_t>(&noise));
  const LightSpots eight = spots;
  CHECK(eight.size() >= 10);

  SpotSettings deep = settings;
  deep.full_scale_dn = 255.0 * 257.0;
  deep.gain_electrons_dn = test::lamp_gain / 257.0;
  deep.read_noise_dn = test::lamp_read_noise * 257.0;
  CHECK(finder->configure(deep) == Status::ok);
  const std::vector<std::uint16_t> pixels = scene.expose<std::uint16_t>(&same_noise, 257.0);
  CHECK(finder->find(view_of(scene, pixels), spots, report) == Status::ok);
  CHECK_EQUAL(eight.size(), spots.size());
  for (std::size_t i = 0; i < spots.size() && i < eight.size(); ++i) {
    DOUBLES_EQUAL(eight[i].uv_px(0), spots[i].uv_px(0), 0.01);
    DOUBLES_EQUAL(eight[i].uv_px(1), spots[i].uv_px(1), 0.01);
    DOUBLES_EQUAL(eight[i].flux, spots[i].flux, 0.02 * eight[i].flux);
    CHECK_EQUAL(eight[i].saturated_px, spots[i].saturated_px);
  }
}

TEST(LightSpotFinder, SixteenBitsAreSearchedToTheLast) {
  // A spot between 8-bit levels, at a right edge that is no multiple of 16 pixels.
  Scene scene(77, 40, 2.0);
  scene.add({70.4, 20.3, 1.0, 200.0});
  SpotSettings deep = settings;
  deep.full_scale_dn = 4095.0;
  deep.gain_electrons_dn = 10.0;
  CHECK(finder->configure(deep) == Status::ok);
  const std::vector<std::uint16_t> pixels = scene.expose<std::uint16_t>(nullptr, 16.0);
  CHECK(finder->find(view_of(scene, pixels), spots, report) == Status::ok);
  CHECK_EQUAL(1U, spots.size());
  DOUBLES_EQUAL(70.4, spots[0].uv_px(0), 0.01);
  DOUBLES_EQUAL(20.3, spots[0].uv_px(1), 0.01);
}

TEST(LightSpotFinder, SpotsAtTheBorderAreFoundOrLeftOutButNeverWrong) {
  for (const double offset : {-1.0, 0.0, 0.7, 1.5, 3.2}) {
    Scene scene(90, 70, 3.0);
    const std::vector<Lamp> lamps{{offset, 35.3, 1.5, 500.0},
                                  {89.0 - offset, 30.6, 1.5, 200.0},
                                  {40.2, offset, 1.0, 200.0},
                                  {50.7, 69.0 - offset, 2.0, 900.0},
                                  {offset, offset, 2.0, 250.0}};
    for (const Lamp& lamp : lamps) scene.add(lamp);
    find(scene, scene.expose<std::uint8_t>(nullptr));
    if (offset > 1.0) CHECK_EQUAL(lamps.size(), spots.size());
    for (const LightSpot& spot : spots) {
      const bool right = std::any_of(lamps.begin(), lamps.end(), [&](const Lamp& lamp) {
        const double error = std::hypot(spot.uv_px(0) - lamp.u, spot.uv_px(1) - lamp.v);
        return error < std::max(0.1, 4.0 * spot.sigma_px);
      });
      CHECK(right);
    }
  }
}

TEST(LightSpotFinder, EmptyImagesHaveNoSpots) {
  for (const double level : {0.0, 60.0, 254.0, 255.0, 400.0}) {
    for (const int width : {640, 61, 7}) {
      const Scene scene(width, 64, level);
      relnav::test::Normal noise(2);
      find(scene, scene.expose<std::uint8_t>(level < 250.0 ? &noise : nullptr));
      CHECK_EQUAL(0U, spots.size());
      CHECK_EQUAL(0, report.overflow);
      CHECK(!report.overflowed());
    }
  }
}

TEST(LightSpotFinder, OneGiantRegionIsNoSpotAndHidesNone) {
  Scene scene(640, 480, 2.0);
  for (int v = 0; v < 480; ++v) {
    for (int u = 0; u < 400; ++u) scene.at(u, v) = 255.0;
  }
  scene.add({520.4, 240.6, 2.0, 300.0});
  find(scene, scene.expose<std::uint8_t>(nullptr));
  CHECK_EQUAL(1U, spots.size());
  DOUBLES_EQUAL(520.4, spots[0].uv_px(0), 0.02);
  CHECK(report.rejected > 0);
}

TEST(LightSpotFinder, GateLeavesOutWhatHasTheWrongShape) {
  Scene scene(200, 100, 2.0);
  for (int i = 0; i < 30; ++i) scene.add({20.0 + i, 20.0 + 0.3 * i, 0.0, 120.0});  // a streak
  for (int v = 60; v < 90; ++v) {
    for (int u = 20; u < 60; ++u) scene.at(u, v) = 200.0;  // too large
  }
  for (int k = 0; k < 40; ++k) {  // a ring
    scene.add({120.0 + 6.0 * std::cos(0.05 * std::numbers::pi * k), 50.0 + 6.0 * std::sin(0.05 * std::numbers::pi * k),
               0.0, 90.0});
  }
  scene.at(160, 20) = 250.0;  // a hot pixel
  scene.add({160.3, 70.2, 1.5, 200.0});
  find(scene, scene.expose<std::uint8_t>(nullptr));
  CHECK_EQUAL(1U, spots.size());
  DOUBLES_EQUAL(160.3, spots[0].uv_px(0), 0.01);
  CHECK(report.rejected >= 4);
}

TEST(LightSpotFinder, OverflowKeepsTheStrongestAndSaysHowManyThereWere) {
  Scene scene(640, 480, 2.0);
  int count = 0;
  for (int row = 0; row < 10; ++row) {
    for (int column = 0; column < 12; ++column, ++count) {
      // Not in order of brightness; every third is strong.
      scene.add({30.3 + 48.0 * column, 30.6 + 44.0 * row, 1.5, count % 3 == 0 ? 200.0 : 80.0});
    }
  }
  find(scene, scene.expose<std::uint8_t>(nullptr));
  CHECK_EQUAL(config::max_spots, spots.size());
  CHECK_EQUAL(count, report.found);
  CHECK_EQUAL(count - static_cast<int>(config::max_spots), report.overflow);
  CHECK(report.overflowed());
  int strong = 0;
  for (std::size_t i = 0; i < spots.size(); ++i) {
    if (i > 0) CHECK(spots[i].flux <= spots[i - 1].flux);
    if (spots[i].flux > 4.0) ++strong;
  }
  CHECK_EQUAL(count / 3, strong);
}

TEST(LightSpotFinder, TooManyRunsRaiseTheThresholdAndAreCounted) {
  // Fine stripes fill the table of runs at once; the spots stand above it.
  Scene scene(640, 480, 0.0);
  for (int v = 0; v < 480; ++v) {
    for (int u = 0; u < 640; ++u) scene.at(u, v) = (u + v) % 26 < 2 ? 90.0 : 0.0;
  }
  scene.add({200.4, 200.4, 3.0, 600.0});
  find(scene, scene.expose<std::uint8_t>(nullptr));
  CHECK(report.raised > 0);
  CHECK_EQUAL(0, report.dropped_runs);
  CHECK(nearest(spots, 200.4, 200.4) != nullptr);

  for (int v = 0; v < 480; ++v) {
    for (int u = 0; u < 640; ++u) scene.at(u, v) = (u + v) % 26 < 2 ? 255.0 : 0.0;
  }
  find(scene, scene.expose<std::uint8_t>(nullptr));
  CHECK(report.dropped_runs > 0);
  CHECK(report.overflowed());
}

TEST(LightSpotFinder, WindowsGiveWhatTheWholeImageGives) {
  Scene scene(320, 240, 4.0);
  const std::vector<Lamp> lamps{{60.3, 50.2, 2.0, 400.0}, {200.7, 80.4, 4.0, 900.0}, {120.1, 190.9, 0.0, 150.0}};
  for (const Lamp& lamp : lamps) scene.add(lamp);
  relnav::test::Normal noise(4);
  const std::vector<std::uint8_t> pixels = scene.expose<std::uint8_t>(&noise);
  find(scene, pixels);
  const LightSpots whole = spots;
  CHECK_EQUAL(3U, whole.size());

  // The second twice, by windows that overlap; the third is in none; one window reaches out of the image.
  const std::vector<PixelRegion> windows{
      {48, 38, 72, 62}, {188, 68, 212, 92}, {190, 72, 214, 96}, {300, 220, 340, 260}, {50, 50, 50, 60}};
  CHECK(finder->find(view_of(scene, pixels), windows, 0, spots, report) == Status::ok);
  CHECK_EQUAL(2U, spots.size());
  CHECK_EQUAL(1, report.repeated);
  for (const LightSpot& spot : spots) {
    const LightSpot* same = nearest(whole, spot.uv_px(0), spot.uv_px(1));
    CHECK(same != nullptr);
    if (same == nullptr) return;
    CHECK((same->uv_px - spot.uv_px).norm() < 0.3 * spot.sigma_px);
    DOUBLES_EQUAL(same->flux, spot.flux, 0.05 * spot.flux);
  }

  // Of the three, the middle of the first only lies 8 px inside of its window.
  const std::vector<PixelRegion> off_centre{{48, 38, 72, 62}, {195, 68, 219, 92}};
  CHECK(finder->find(view_of(scene, pixels), off_centre, 8, spots, report) == Status::ok);
  CHECK_EQUAL(1U, spots.size());
  CHECK(nearest(spots, lamps[0].u, lamps[0].v) != nullptr);
}

TEST(LightSpotFinder, SameImageSameSpots) {
  const test::OwnedImage clutter = test::facets(320, 240, 6);
  CHECK(finder->find(clutter.view(), spots, report) == Status::ok);
  const LightSpots first = spots;
  const SpotReport first_report = report;
  Scene other(320, 240, 10.0);
  other.add({100.0, 100.0, 2.0, 500.0});
  find(other, other.expose<std::uint8_t>(nullptr));
  CHECK_EQUAL(1U, spots.size());
  CHECK(finder->find(clutter.view(), spots, report) == Status::ok);
  CHECK(first.size() > 0);
  CHECK_EQUAL(first.size(), spots.size());
  CHECK_EQUAL(first_report.found, report.found);
  for (std::size_t i = 0; i < spots.size() && i < first.size(); ++i) {
    CHECK(first[i].uv_px == spots[i].uv_px);
    CHECK(first[i].sigma_px == spots[i].sigma_px);  // bit for bit
  }
}

TEST(LightSpotFinder, RefusesWhatItCannotDo) {
  const auto plain = std::make_unique<LightSpotFinder>();
  const Scene scene(32, 32, 0.0);
  const std::vector<std::uint8_t> pixels = scene.expose<std::uint8_t>(nullptr);
  CHECK(plain->find(view_of(scene, pixels), spots, report) == Status::not_configured);
  CHECK(finder->find(ImageView{}, spots, report) == Status::invalid_argument);
  SpotSettings bad = settings;
  bad.gain_electrons_dn = 0.0;
  CHECK(finder->configure(bad) == Status::invalid_argument);
  bad = settings;
  bad.max_area_px = 1;
  CHECK(finder->configure(bad) == Status::invalid_argument);
}

}  // namespace relnav::vision
