#include <dirent.h>

#include <algorithm>

#include "hil/io/image.hpp"
#include "platform/linux/aravis_driver.hpp"
#include "tests/hil/gige/served_camera.hpp"

#include <CppUTest/TestHarness.h>  // last: it redefines new

using namespace relnav;
using platform::linux::AravisDriver;
using platform::linux::CameraSettings;
using platform::linux::RawFormat;
using platform::linux::RawImage;
using platform::linux::Trigger;

namespace {

constexpr Duration long_wait{1'000'000'000};

std::size_t open_files() {
  std::size_t count = 0;
  DIR* const folder = ::opendir("/proc/self/fd");
  while (::readdir(folder) != nullptr) ++count;
  ::closedir(folder);
  return count;
}

bool same_bytes(const RawImage& image, const hil::Image& expected) {
  return image.bytes.size() == expected.bytes.size() &&
         std::equal(image.bytes.begin(), image.bytes.end(), expected.bytes.begin());
}

void check_text(const std::string& text, const char* part) {
  if (text.find(part) == std::string::npos) FAIL(("'" + text + "' lacks '" + part + "'").c_str());
}

}  // namespace

TEST_GROUP(AravisDriver) {
  AravisDriver driver;
  void setup() override { enter_own_network(); }
  void teardown() override { driver.close(); }

  void open(const CameraSettings& settings) {
    const Status status = open_soon(driver, settings);
    if (status != Status::ok) FAIL((std::string(to_string(status)) + ": " + driver.problem()).c_str());
  }
};

TEST(AravisDriver, LockStepGivesEveryByteAndOriginalStamp) {
  hil::CapturedSource source(lights_mono);
  hil::PlayerSettings play;
  play.speed = 0.0;
  play.loop = true;  // stays until it is finished
  ServedCamera camera(source, play);
  CameraSettings settings = settings_for(source.shape().width_px, source.shape().height_px);
  settings.trigger = Trigger::software;
  open(settings);
  for (std::size_t k = 0; k < source.count(); ++k) {
    CHECK_TRUE(driver.trigger() == Status::ok);
    RawImage image;
    CHECK_TRUE(driver.take(long_wait, image) == Status::ok);
    CHECK_TRUE(image.complete);
    CHECK_TRUE(image.format == RawFormat::grey8);
    CHECK_TRUE(image.stamp == source.stamp(k));
    CHECK_TRUE(image.clock == hal::ClockId::device);
    CHECK_EQUAL(k, image.sequence);
    CHECK_EQUAL(source.shape().width_px, image.stride_bytes);
    CHECK_TRUE(same_bytes(image, *source.image(k)));
    CHECK_TRUE(image.first_data <= image.dequeued);
    CHECK_TRUE((image.dequeued - image.first_data).ns < 500'000'000);
    CHECK_TRUE(driver.give_back(image.buffer) == Status::ok);
    CHECK_TRUE(driver.give_back(image.buffer) == Status::stale_handle);
  }
  driver.close();  // while the camera is there
  CHECK_EQUAL(source.count(), camera.finish().sent);
}

TEST(AravisDriver, SixteenBitsCarryTheEightInTheirUpperHalf) {
  hil::CapturedSource source(lights_mono);
  hil::PlayerSettings play;
  play.speed = 0.0;
  play.loop = true;  // stays until it is finished
  ServedCamera camera(source, play);
  CameraSettings settings = settings_for(source.shape().width_px, source.shape().height_px);
  settings.format = "";  // the deepest
  settings.trigger = Trigger::software;
  open(settings);
  CHECK_TRUE(driver.trigger() == Status::ok);
  RawImage image;
  CHECK_TRUE(driver.take(long_wait, image) == Status::ok);
  CHECK_TRUE(image.complete);
  CHECK_TRUE(image.format == RawFormat::y16);
  CHECK_EQUAL(2 * source.shape().width_px, image.stride_bytes);
  const hil::Image& expected = *source.image(0);
  CHECK_EQUAL(2 * expected.bytes.size(), image.bytes.size());
  for (std::size_t i = 0; i < expected.bytes.size(); ++i) {
    if (image.bytes[2 * i] != 0 || image.bytes[2 * i + 1] != expected.bytes[i]) FAIL("a pixel differs");
  }
  CHECK_TRUE(driver.give_back(image.buffer) == Status::ok);
  driver.close();
}

TEST(AravisDriver, LostFramesAreGapsAndLostPacketsIncompleteFrames) {
  CountedFrames source(640, 480, 1000, 50.0);
  hil::PlayerSettings play;
  play.faults = {hil::parse_fault("lost@10:3"), hil::parse_fault("packets@30:1:200")};
  ServedCamera camera(source, play);
  open(settings_for(640, 480));
  int damaged = 0;  // it bears no number
  std::vector<std::uint32_t> good;
  while (true) {
    RawImage image;
    if (driver.take(long_wait, image) != Status::ok) break;
    damaged += image.complete ? 0 : 1;
    if (image.complete) {
      good.push_back(image.sequence);
      CHECK_TRUE(same_bytes(image, *source.image(image.sequence)));
      CHECK_EQUAL(image.sequence, source.index_of(image.stamp));
    }
    CHECK_TRUE(driver.give_back(image.buffer) == Status::ok);
    if (image.sequence == 59) break;
  }
  driver.close();
  const hil::PlayedFrames played = camera.finish();
  CHECK_EQUAL(3, played.lost);
  CHECK_EQUAL(0, played.unseen);
  for (const std::uint32_t sequence : {10U, 11U, 12U, 30U})
    CHECK_TRUE(std::find(good.begin(), good.end(), sequence) == good.end());
  CHECK_TRUE(std::is_sorted(good.begin(), good.end()));
  CHECK_EQUAL(56, good.size());
  CHECK_EQUAL(1, damaged);
  CHECK_EQUAL(0, driver.underruns());
}

TEST(AravisDriver, WhatIsWrongIsSaidInOneLine) {
  RawImage image;
  CHECK_TRUE(driver.take(Duration{0}, image) == Status::not_configured);
  CHECK_TRUE(driver.open(settings_for(640, 480)) == Status::no_data);
  check_text(driver.problem(), "camera 127.0.0.1: nothing answers there");

  CountedFrames source(640, 480, 1000, 20.0);
  ServedCamera camera(source, {});
  open(settings_for(640, 480));  // it is there
  driver.close();

  CameraSettings settings = settings_for(640, 480);
  settings.serial = "RN02";
  CHECK_TRUE(driver.open(settings) == Status::unsupported);
  check_text(driver.problem(), "its serial number is RN01 (expected RN02)");

  settings = settings_for(640, 480);
  settings.format = "y10";
  CHECK_TRUE(driver.open(settings) == Status::unsupported);
  check_text(driver.problem(), "pixel format y10 is not offered (expected y16, grey8");
  settings.format = "grey9";
  CHECK_TRUE(driver.open(settings) == Status::unsupported);
  check_text(driver.problem(), "there is no pixel format 'grey9' (expected y16, grey8");

  CHECK_TRUE(driver.open(settings_for(800, 480)) == Status::unsupported);
  check_text(driver.problem(), "width 800 px is not offered (expected");
  CHECK_TRUE(driver.open(settings_for(0, 480)) == Status::invalid_argument);

  settings = settings_for(640, 480);
  settings.rate_hz = 1e6;
  CHECK_TRUE(driver.open(settings) == Status::unsupported);
  check_text(driver.problem(), "a rate in Hz of 1e+06 is not offered");
  settings.rate_hz = 0.0;
  settings.exposure_us = 1e12;
  CHECK_TRUE(driver.open(settings) == Status::unsupported);
  check_text(driver.problem(), "an exposure in us of 1e+12 is not offered");
  settings.exposure_us = 0.0;
  settings.trigger = Trigger::line;
  const Status line = driver.open(settings);
  if (line != Status::ok) check_text(driver.problem(), "trigger");

  AravisDriver other;
  open(settings_for(640, 480));
  CHECK_TRUE(other.open(settings_for(640, 480)) == Status::no_capacity);
  check_text(other.problem(), "busy");
  // The one that has it is not disturbed.
  CHECK_TRUE(driver.take(long_wait, image) == Status::ok);
  driver.close();
}

TEST(AravisDriver, ACameraThatVanishesComesBackAndNothingLeaks) {
  constexpr int cycles = 3;
  CountedFrames source(640, 480, 100000, 100.0);
  hil::PlayerSettings play;
  for (int i = 0; i < cycles; ++i) {
    hil::Fault fault = hil::parse_fault("unplug@0:700");
    fault.frame = static_cast<std::uint64_t>(50 + 300 * i);
    play.faults.push_back(fault);
  }
  ServedCamera camera(source, play);
  CameraSettings settings = settings_for(640, 480);
  open(settings);
  std::size_t files_before = 0;
  for (int i = 0; i < cycles; ++i) {
    Status status = Status::ok;
    int frames = 0;
    while (status == Status::ok) {
      RawImage image;
      status = driver.take(Duration{300'000'000}, image);
      if (status != Status::ok) break;
      ++frames;
      CHECK_TRUE(driver.give_back(image.buffer) == Status::ok);
    }
    CHECK_TRUE(status == Status::timeout || status == Status::device_lost);
    CHECK_TRUE(frames > 10);
    const auto before = std::chrono::steady_clock::now();
    driver.close();  // as StreamCamera does with a camera that has gone silent
    const auto closed = std::chrono::steady_clock::now() - before;
    CHECK_TRUE(closed < std::chrono::milliseconds(500));
    open(settings);
    RawImage image;
    CHECK_TRUE(driver.take(long_wait, image) == Status::ok);
    CHECK_TRUE(driver.give_back(image.buffer) == Status::ok);
    std::this_thread::sleep_for(std::chrono::seconds(1));  // of a session that is taken down
    if (i == 0)
      files_before = open_files();
    else
      CHECK_TRUE(open_files() <= files_before + 2);
  }
  driver.close();
}

TEST(AravisDriver, HeartbeatFindsOutThatACameraForgotUs) {
  CountedFrames source(640, 480, 100000, 100.0);
  hil::PlayerSettings play;
  play.faults = {hil::parse_fault("unplug@20:200")};
  ServedCamera camera(source, play);
  open(settings_for(640, 480));
  Status status = Status::ok;
  const auto start = std::chrono::steady_clock::now();
  while (status != Status::device_lost && std::chrono::steady_clock::now() - start < std::chrono::seconds(8)) {
    RawImage image;
    status = driver.take(Duration{50'000'000}, image);
    if (status == Status::ok) CHECK_TRUE(driver.give_back(image.buffer) == Status::ok);
  }
  CHECK_TRUE(status == Status::device_lost);
  check_text(driver.problem(), "does not answer any more");
  CHECK_TRUE(driver.trigger() == Status::device_lost);
  driver.close();
}
