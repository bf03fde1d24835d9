// A configuration as bytes and back. That no value of the configuration file is left out: tests/unit/hil/test_target_pack.cpp.
#include "fsw/app/config_image.hpp"

#include <algorithm>
#include <array>
#include <span>

#include <CppUTest/TestHarness.h>

using namespace relnav;
using app::FlightLoopConfig;

TEST_GROUP(ConfigImage) {
  std::array<std::uint8_t, app::max_config_image_bytes> memory{};
  std::size_t size = 0;
  FlightLoopConfig config = FlightLoopConfig::defaults(MotionKind::camera);

  void setup() override {
    config.navigation = app::NavigationKind::coop_stereo;
    config.camera = {700.5, 701.5, 319.5, 239.5, 640, 480, DistortionModel::equidistant, {0.1, -0.2, 0.3, -0.4}};
    config.second.R_C1C0 << 0.0, 1.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 1.0;
    config.second.t_C1C0 = Vec3(-0.5, 0.25, 1e-300);
    config.navigator.filter.seed = 0xFEDCBA9876543210ULL;
    config.coop.phi_CT_expected.z() = -0.0;
    config.lines.heartbeat = 11;
    config.lines.pulse = 12;
    config.lines.exposure = 13;
    config.lines.time = {Duration{2'078'691'237'000'000'000}, Duration{2}, 3, 4, 5, 6, Duration{7'000'000'000}};
    config.exposure.enabled = true;
    config.exposure.gain_max = 7.5;
    config.exposure.exposure_max = Duration{8'000'000};
    for (std::uint16_t id = 0; id < config::max_target_features; ++id) {
      CHECK(config.coop.target.features.push_back({id, Vec3(id, -1.0, 0.5), Vec3(0.0, 0.0, 1.0)}) == Status::ok);
    }
    for (std::uint16_t i = 1; i < config::max_target_lines; ++i) {
      CHECK(config.coop.target.lines.push_back({static_cast<std::uint16_t>(i - 1), i}) == Status::ok);
    }
  }
  std::span<std::uint8_t> image() {
    CHECK(app::write_config_image(config, memory, size) == Status::ok);
    return std::span(memory).first(size);
  }
  /// The status of reading `bytes`, after which the configuration read into must be as before.
  Status refusal(std::span<const std::uint8_t> bytes) {
    FlightLoopConfig read;
    read.min_inliers = 77;
    const Status status = app::read_config_image(bytes, read);
    CHECK(status != Status::ok);
    LONGS_EQUAL(77, read.min_inliers);
    LONGS_EQUAL(0, read.coop.target.features.size());
    return status;
  }
};

TEST(ConfigImage, TheLargestComesBack) {
  const std::span<std::uint8_t> written = image();
  FlightLoopConfig read;
  CHECK(app::read_config_image(written, read) == Status::ok);
  std::array<std::uint8_t, app::max_config_image_bytes> again{};
  std::size_t again_size = 0;
  CHECK(app::write_config_image(read, again, again_size) == Status::ok);
  CHECK(std::equal(written.begin(), written.end(), again.begin(), again.begin() + again_size));
  CHECK(read.navigation == app::NavigationKind::coop_stereo);
  CHECK(read.camera.model == DistortionModel::equidistant);
  DOUBLES_EQUAL(-0.4, read.camera.coefficients[3], 0.0);
  CHECK(read.second.R_C1C0 == config.second.R_C1C0);
  CHECK(read.navigator.filter.seed == config.navigator.filter.seed);
  LONGS_EQUAL(63, read.coop.target.features[63].id);
  LONGS_EQUAL(11, read.lines.heartbeat);
  LONGS_EQUAL(12, read.lines.pulse);
  LONGS_EQUAL(13, read.lines.exposure);
  CHECK(read.lines.time.tai_offset == config.lines.time.tai_offset);
  LONGS_EQUAL(2, read.lines.time.tolerance.ns);
  LONGS_EQUAL(3, read.lines.time.max_drift_ppb);
  LONGS_EQUAL(4, read.lines.time.drift_change_ppb);
  LONGS_EQUAL(5, read.lines.time.lock_pulses);
  LONGS_EQUAL(6, read.lines.time.restart_pulses);
  LONGS_EQUAL(7'000'000'000, read.lines.time.holdover_after.ns);
  CHECK(read.exposure.enabled);
  DOUBLES_EQUAL(7.5, read.exposure.gain_max, 0.0);
  LONGS_EQUAL(8'000'000, read.exposure.exposure_max.ns);
  LONGS_EQUAL(62, read.coop.target.lines[62].from);
}

TEST(ConfigImage, DamageIsSeen) {
  const std::span<std::uint8_t> whole = image();
  for (std::size_t cut = 0; cut < whole.size(); cut += 7) CHECK(refusal(whole.first(cut)) != Status::ok);
  for (std::size_t byte = 0; byte < whole.size(); byte += 3) {
    whole[byte] ^= 0x40U;
    CHECK(refusal(whole) != Status::ok);
    whole[byte] ^= 0x40U;
  }
  whole[5] += 1U;
  CHECK(refusal(whole) == Status::unsupported);  // another version
}

TEST(ConfigImage, NeedsRoom) {
  const std::size_t needed = image().size();
  CHECK(app::write_config_image(config, std::span(memory).first(needed - 1), size) == Status::no_capacity);
  CHECK(app::write_config_image(config, std::span(memory).first(3), size) == Status::no_capacity);
  CHECK(app::write_config_image(config, std::span(memory).first(needed), size) == Status::ok);
}
