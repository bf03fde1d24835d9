// Brightness of the lit part of an image.
#include "fsw/vision/brightness.hpp"

#include <algorithm>
#include <cstdint>
#include <vector>

#include <CppUTest/TestHarness.h>

using namespace relnav;
using vision::Brightness;
using vision::BrightnessSettings;

TEST_GROUP(Brightness) {
  BrightnessSettings settings;
  std::vector<std::uint8_t> pixels = std::vector<std::uint8_t>(64 * 48, 3);
  void setup() override { settings.sample_step_px = 1; }
  [[nodiscard]] Brightness measured() const {
    return vision::measure_brightness(vision::ImageView{pixels.data(), 64, 48, 64}, 8, settings);
  }
  /// The next `count` pixels.
  std::size_t at = 0;
  void paint(std::size_t count, std::uint8_t level) {
    std::fill_n(pixels.begin() + static_cast<std::ptrdiff_t>(at), count, level);
    at += count;
  }
};

TEST(Brightness, SpaceDoesNotCount) {
  paint(100, 100);
  const Brightness b = measured();
  LONGS_EQUAL(64 * 48, b.samples);
  LONGS_EQUAL(100, b.bright);
  LONGS_EQUAL(100, b.level);
  LONGS_EQUAL(100, b.peak_level);
  LONGS_EQUAL(0, b.saturated);
}

TEST(Brightness, TheDarkLevelItselfIsDark) {
  paint(100, 24);
  LONGS_EQUAL(0, measured().bright);
  LONGS_EQUAL(0, measured().level);
  paint(1, 25);
  LONGS_EQUAL(1, measured().bright);
  LONGS_EQUAL(25, measured().level);
}

TEST(Brightness, TheLevelIsTheQuantile) {
  for (int i = 0; i < 100; ++i) paint(1, static_cast<std::uint8_t>(100 + i));
  LONGS_EQUAL(189, measured().level);  // ten of a hundred are brighter
  LONGS_EQUAL(197, measured().peak_level);
  settings.bright_permille = 500;
  LONGS_EQUAL(149, measured().level);
  settings.saturated_permille = 0;
  LONGS_EQUAL(199, measured().peak_level);
  settings.saturated_permille = 1000;
  LONGS_EQUAL(0, measured().peak_level);
}

TEST(Brightness, SaturatedPixelsThatMayBeAreLeftOut) {
  paint(900, 100);
  paint(100, 250);
  settings.saturated_permille = 100;
  LONGS_EQUAL(100, measured().saturated);
  LONGS_EQUAL(100, measured().level);
  LONGS_EQUAL(100, measured().peak_level);
  settings.saturated_permille = 99;
  LONGS_EQUAL(250, measured().peak_level);
  settings.saturated_permille = 20;
  LONGS_EQUAL(100, measured().level);  // 80 are left of 980: under a tenth
  paint(50, 255);
  LONGS_EQUAL(255 - 5, measured().level);
}

TEST(Brightness, LooksAtEveryStepthPixelOfEveryStepthRow) {
  settings.sample_step_px = 4;
  LONGS_EQUAL(16 * 12, measured().samples);
  pixels[2 * 64 + 6] = 200;  // (6, 2) is looked at
  pixels[2 * 64 + 7] = 200;
  pixels[3 * 64 + 6] = 200;
  LONGS_EQUAL(1, measured().bright);
  settings.sample_step_px = 16;
  LONGS_EQUAL(4 * 3, measured().samples);
}

TEST(Brightness, DeepPixelsCountByTheirUpperBits) {
  std::vector<std::uint16_t> deep(64 * 48, 100);
  std::fill_n(deep.begin(), 50, std::uint16_t{2000});
  std::fill_n(deep.begin() + 50, 50, std::uint16_t{0xFFFF});  // more than the sensor has bits
  const Brightness b = vision::measure_brightness(vision::ImageView16{deep.data(), 64, 48, 64}, 12, settings);
  LONGS_EQUAL(100, b.bright);
  LONGS_EQUAL(50, b.saturated);
  LONGS_EQUAL(255, b.level);
  settings.saturated_permille = 500;
  LONGS_EQUAL(125, vision::measure_brightness(vision::ImageView16{deep.data(), 64, 48, 64}, 12, settings).level);
}

TEST(Brightness, NoImageHasNoSamples) {
  const Brightness b = vision::measure_brightness(vision::ImageView{}, 8, settings);
  LONGS_EQUAL(0, b.samples);
  LONGS_EQUAL(0, b.level);
}

TEST(Brightness, RowsAreTakenByTheirStride) {
  settings.sample_step_px = 1;
  for (std::size_t v = 0; v < 48; ++v)
    std::fill_n(pixels.begin() + static_cast<std::ptrdiff_t>(64 * v + 32), 32, std::uint8_t{200});
  const Brightness b = vision::measure_brightness(vision::ImageView{pixels.data(), 32, 48, 64}, 8, settings);
  LONGS_EQUAL(32 * 48, b.samples);
  LONGS_EQUAL(0, b.bright);
}
