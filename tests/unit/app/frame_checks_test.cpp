#include "fsw/app/frame_checks.hpp"

#include <array>
#include <bit>
#include <cstdint>

#include <CppUTest/TestHarness.h>

using namespace relnav;

namespace {

constexpr std::uint32_t width_px = 16;
constexpr std::uint32_t height_px = 8;

/// A 16-bit image of `low` with one pixel of `high`.
app::FrameCheck check(std::uint16_t low, std::uint16_t high, int sensor_bits) {
  std::array<std::array<std::uint8_t, 2>, width_px * height_px> pixels;
  pixels.fill(std::bit_cast<std::array<std::uint8_t, 2>>(low));
  pixels[3] = std::bit_cast<std::array<std::uint8_t, 2>>(high);
  hal::Frame frame;
  frame.pixels = pixels[0].data();
  frame.width_px = width_px;
  frame.height_px = height_px;
  frame.stride_bytes = 2 * width_px;
  frame.format = hal::PixelFormat::mono16;
  frame.mid_exposure = Time{1'000'000'000};
  app::FrameChecks checks;
  checks.configure({}, width_px, height_px, sensor_bits);
  return checks.check(frame, Time{1'000'000'000}, hal::ClockId::monotonic);
}

}  // namespace

TEST_GROUP(FrameChecks){};

TEST(FrameChecks, ContrastOfSixteenBitsIsJudgedOnTheScaleOfEight) {
  for (const int bits : {10, 12, 16}) {
    const int level = 1 << (bits - 8);  // of 255
    const auto at = [&](int of_255) { return static_cast<std::uint16_t>(of_255 * level); };
    const app::FrameCheck enough = check(at(10), at(26), bits);
    CHECK_TRUE(enough.fault == app::FrameFault::none);
    LONGS_EQUAL(10, enough.darkest);
    LONGS_EQUAL(26, enough.brightest);
    CHECK_TRUE(check(at(10), at(25), bits).fault == app::FrameFault::no_contrast);
  }
}
