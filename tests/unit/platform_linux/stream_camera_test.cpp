// StreamCamera beyond the contract: newest frame, stamps, numbers, loss and return, leases over a loss.
#include "platform/linux/stream_camera.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "tests/support/allocation_trap.hpp"
#include "tests/support/scripted_driver.hpp"

#include <CppUTest/TestHarness.h>

using namespace relnav;
using namespace relnav::platform::linux;
using test::ScriptedDriver;

namespace {

constexpr std::int64_t ms = 1'000'000;
constexpr Duration wait{5 * ms};

void check_ns(std::int64_t expected, std::int64_t actual) { CHECK_EQUAL(expected, actual); }

/// Always has its one image, `waiting` times; takes no heap while it streams.
class PreparedDriver final : public CameraDriver {
 public:
  PreparedDriver(RawFormat format, hal::Clock& clock) : clock_(clock) {
    image_.format = format;
    image_.width_px = 8;
    image_.height_px = 4;
    image_.stride_bytes = 16;
    image_.bytes = bytes_;
  }
  int waiting = 0;

  Status open(const CameraSettings&) override { return Status::ok; }
  void close() override {}
  Status take(Duration, RawImage& image) override {
    if (waiting == 0) return Status::timeout;
    --waiting;
    ++taken_;
    image = image_;
    image.complete = taken_ % 5 != 0;
    image.stamp = image.first_data = image.dequeued = clock_.now();
    return Status::ok;
  }
  Status give_back(std::uint32_t) override { return Status::ok; }
  Status trigger() override { return Status::unsupported; }
  Status exposure_range(ExposureRange&) override { return Status::unsupported; }
  Status adjust(ExposureValues&) override { return Status::unsupported; }
  [[nodiscard]] std::uint32_t max_loans() const override { return 4; }
  [[nodiscard]] std::uint64_t underruns() const override { return 0; }
  [[nodiscard]] const std::string& problem() const override { return problem_; }

 private:
  hal::Clock& clock_;
  std::array<std::uint8_t, 64> bytes_{};
  RawImage image_;
  std::uint32_t taken_ = 0;
  std::string problem_;
};

}  // namespace

TEST_GROUP(StreamCamera) {
  platform::host::ScriptedClock clock{Time{1'000'000'000}};
  ScriptedDriver driver{clock};
  CameraSettings settings;
  StreamOptions options;
  std::unique_ptr<StreamCamera> camera;
  hal::Frame frame;

  void setup() override {
    settings.device = "/dev/video7";
    settings.width_px = 8;
    settings.height_px = 4;
  }
  void teardown() override {
    camera.reset();
    LONGS_EQUAL(0, driver.mistakes);
    CHECK_FALSE(driver.is_open());
    LONGS_EQUAL(0, driver.loans());
  }
  void build() { camera = std::make_unique<StreamCamera>(driver, clock, settings, options); }
  void start() {
    build();
    CHECK_TRUE(camera->start() == Status::ok);
  }
  Status acquire() { return camera->acquire(wait, frame); }
  /// The next good frame; given back at once.
  hal::Frame deliver() {
    driver.offer_good();
    return deliver_waiting();
  }
  hal::Frame deliver_waiting() {
    CHECK_TRUE(acquire() == Status::ok);
    CHECK_TRUE(camera->release(frame) == Status::ok);
    return frame;
  }
  void pass(std::int64_t milliseconds) { clock.advance(Duration{milliseconds * ms}); }
  bool says(const char* part) const { return camera->problem().find(part) != std::string::npos; }
};

TEST(StreamCamera, LendsTheDriversOwnBuffers) {
  driver.padding_bytes = 3;
  start();
  driver.offer_good();
  CHECK_TRUE(acquire() == Status::ok);
  CHECK_TRUE(driver.lends(frame.pixels));
  LONGS_EQUAL(11, frame.stride_bytes);
  LONGS_EQUAL(8, frame.width_px);
  LONGS_EQUAL(4, frame.height_px);
  CHECK_TRUE(frame.format == hal::PixelFormat::mono8);
  CHECK_TRUE(camera->release(frame) == Status::ok);
  LONGS_EQUAL(0, driver.loans());
  LONGS_EQUAL(1, camera->counts().delivered);
}

TEST(StreamCamera, ConvertsIntoItsOwnMemory) {
  driver.format = RawFormat::y12p;
  start();
  driver.offer_good();  // every byte is 1: pixels 0x101 and 0x010
  CHECK_TRUE(acquire() == Status::ok);
  CHECK_FALSE(driver.lends(frame.pixels));
  LONGS_EQUAL(0, driver.loans());  // given back at once
  CHECK_TRUE(frame.format == hal::PixelFormat::mono16);
  LONGS_EQUAL(16, frame.stride_bytes);
  LONGS_EQUAL(0x01, frame.pixels[0]);
  LONGS_EQUAL(0x01, frame.pixels[1]);
  LONGS_EQUAL(0x10, frame.pixels[2]);
  LONGS_EQUAL(0x00, frame.pixels[3]);
  CHECK_TRUE(camera->release(frame) == Status::ok);
}

TEST(StreamCamera, CopiesWhenTheDriverCannotLendMore) {
  driver.loans_allowed = 3;
  start();
  std::vector<hal::Frame> held;
  for (int k = 0; k < 3; ++k) {
    driver.offer_good();
    CHECK_TRUE(acquire() == Status::ok);
    held.push_back(frame);
  }
  CHECK_TRUE(driver.lends(held[0].pixels));
  CHECK_TRUE(driver.lends(held[1].pixels));
  CHECK_FALSE(driver.lends(held[2].pixels));  // one loan is kept for taking the next
  for (int k = 0; k < 3; ++k) LONGS_EQUAL(k + 1, held[static_cast<std::size_t>(k)].pixels[31]);
  for (const hal::Frame& h : held) CHECK_TRUE(camera->release(h) == Status::ok);
  LONGS_EQUAL(3, driver.most_loans);
}

TEST(StreamCamera, CopiesAlwaysWhenToldTo) {
  options.always_copy = true;
  start();
  driver.offer_good();
  CHECK_TRUE(acquire() == Status::ok);
  LONGS_EQUAL(0, driver.loans());
  LONGS_EQUAL(1, frame.pixels[31]);
  CHECK_TRUE(camera->release(frame) == Status::ok);
}

TEST(StreamCamera, CopiesSixteenBitPixelsAtOddStrides) {
  driver.format = RawFormat::y16;
  driver.padding_bytes = 1;
  start();
  driver.offer_good();
  CHECK_TRUE(acquire() == Status::ok);
  CHECK_FALSE(driver.lends(frame.pixels));
  LONGS_EQUAL(16, frame.stride_bytes);
  CHECK_TRUE(camera->release(frame) == Status::ok);
}

TEST(StreamCamera, GivesTheNewestFrame) {
  start();
  for (int k = 0; k < 4; ++k) driver.offer_good();
  CHECK_TRUE(acquire() == Status::ok);
  LONGS_EQUAL(3, frame.sequence);
  LONGS_EQUAL(4, frame.pixels[0]);
  LONGS_EQUAL(3, camera->counts().skipped);
  LONGS_EQUAL(1, driver.loans());
  CHECK_TRUE(camera->release(frame) == Status::ok);
  CHECK_TRUE(acquire() == Status::timeout);
}

TEST(StreamCamera, GivesEveryFrameForRecording) {
  options.policy = FramePolicy::every_frame;
  start();
  for (int k = 0; k < 4; ++k) driver.offer_good();
  for (std::uint32_t k = 0; k < 4; ++k) LONGS_EQUAL(k, deliver_waiting().sequence);
  LONGS_EQUAL(0, camera->counts().skipped);
}

TEST(StreamCamera, AnOlderGoodFrameBeatsANewerDamagedOne) {
  for (const std::uint32_t loans : {1U, 6U}) {
    driver.loans_allowed = loans;
    start();
    driver.offer_good();
    driver.offer_good();
    driver.offer_damaged();
    CHECK_TRUE(acquire() == Status::ok);
    LONGS_EQUAL(1, frame.sequence);
    LONGS_EQUAL(frame.pixels[0], frame.pixels[31]);
    CHECK_TRUE(camera->release(frame) == Status::ok);
    LONGS_EQUAL(1, camera->counts().incomplete);
    LONGS_EQUAL(1, camera->counts().skipped);
    LONGS_EQUAL(3, deliver().sequence);
    LONGS_EQUAL(loans == 1 ? 1 : 2, driver.most_loans);
    camera.reset();
  }
}

TEST(StreamCamera, ABufferThatEndsTooEarlyIsDamaged) {
  start();
  ScriptedDriver::Shot shot = driver.shot();
  shot.bytes_short = 1;
  driver.offer(shot);
  CHECK_TRUE(acquire() == Status::incomplete);
  LONGS_EQUAL(1, camera->counts().incomplete);
  LONGS_EQUAL(0, driver.loans());
  LONGS_EQUAL(1, deliver().sequence);
}

TEST(StreamCamera, NumbersShowWhatTheDriverCounted) {
  start();
  LONGS_EQUAL(0, deliver().sequence);
  driver.skip_sequence(5);
  LONGS_EQUAL(6, deliver().sequence);
}

TEST(StreamCamera, TheNumberOfADamagedFrameMeansNothing) {
  start();
  for (int k = 0; k < 3; ++k) deliver();
  ScriptedDriver::Shot damaged = driver.shot();
  damaged.image.complete = false;
  damaged.image.sequence = 1;  // of the frame that the buffer held before
  driver.offer(damaged);
  CHECK_TRUE(acquire() == Status::incomplete);
  LONGS_EQUAL(4, deliver().sequence);
  LONGS_EQUAL(5, deliver().sequence);
}

TEST(StreamCamera, CountsWhereTheDriverDoesNot) {
  driver.counts = false;
  start();
  LONGS_EQUAL(0, deliver().sequence);
  LONGS_EQUAL(1, deliver().sequence);
  driver.offer_damaged();
  CHECK_TRUE(acquire() == Status::incomplete);
  LONGS_EQUAL(3, deliver().sequence);
}

TEST(StreamCamera, NumbersIncreaseThoughTheDriverCountsAnew) {
  start();
  deliver();
  driver.skip_sequence(9);
  LONGS_EQUAL(10, deliver().sequence);
  driver.restart_sequence();
  LONGS_EQUAL(11, deliver().sequence);
  driver.skip_sequence(2);
  LONGS_EQUAL(14, deliver().sequence);
  CHECK_TRUE(camera->stop() == Status::ok);
  CHECK_TRUE(camera->start() == Status::ok);
  driver.skip_sequence(40);  // more than ever before
  LONGS_EQUAL(15 + 40, deliver().sequence);
}

TEST(StreamCamera, MidExposureFollowsTheMeaningOfTheStamp) {
  start();
  const std::int64_t stamp_ns = clock.peek().ns;
  const auto mid_of = [&](StampMeaning meaning) {
    ScriptedDriver::Shot shot = driver.shot();
    shot.image.stamp_meaning = meaning;
    shot.image.exposure = {4 * ms};
    driver.offer(shot);
    return deliver_waiting().mid_exposure.ns - stamp_ns;
  };
  check_ns(2 * ms, mid_of(StampMeaning::start_of_exposure));
  check_ns(0, mid_of(StampMeaning::mid_exposure));
  check_ns(-2 * ms, mid_of(StampMeaning::end_of_exposure));
  CHECK_TRUE(frame.exposure == Duration{4 * ms});
  CHECK_TRUE(frame.clock == hal::ClockId::monotonic);
}

TEST(StreamCamera, ExposureOfTheSettingsStandsInForOneNotKnown) {
  settings.exposure_us = 6000.0;
  start();
  ScriptedDriver::Shot shot = driver.shot();
  shot.image.stamp_meaning = StampMeaning::end_of_exposure;
  shot.image.gain = 2.5;
  driver.offer(shot);
  CHECK_TRUE(deliver_waiting().mid_exposure == shot.image.stamp + Duration{-3 * ms});
  CHECK_TRUE(frame.exposure == Duration{6 * ms});
  DOUBLES_EQUAL(2.5, camera->gain(), 0.0);
}

TEST(StreamCamera, StampsOfTheDevicesClockAreBroughtToOurs) {
  start();
  const auto mid_of = [&](std::int64_t device_ms, std::int64_t delay_ms) {
    ScriptedDriver::Shot shot = driver.shot();
    shot.image.clock = hal::ClockId::device;
    shot.image.stamp = Time{device_ms * ms};
    shot.image.stamp_meaning = StampMeaning::start_of_exposure;
    shot.image.exposure = {10 * ms};
    clock.jump_to(Time{(5000 + device_ms + 10 + delay_ms) * ms});  // ours is 5 s ahead
    driver.offer(shot);
    return deliver_waiting().mid_exposure.ns;
  };
  check_ns(5005 * ms + ms, mid_of(0, 1));    // the shortest delay is not told from the offset
  check_ns(5105 * ms, mid_of(100, 0));       // none: exact
  const std::int64_t late = mid_of(200, 7);  // arrived late, stamped well
  CHECK_TRUE(late >= 5205 * ms && late <= 5205 * ms + 11'000);
  CHECK_TRUE(frame.clock == hal::ClockId::monotonic);
  CHECK_TRUE(frame.dequeued == clock.peek());
}

TEST(StreamCamera, OriginalStampsAreHandedOutAsTheyAre) {
  settings.original_stamps = true;
  start();
  ScriptedDriver::Shot shot = driver.shot();
  shot.image.stamp = Time{1'700'000'000'123'456'789};
  shot.image.stamp_meaning = StampMeaning::end_of_exposure;
  shot.image.exposure = {4 * ms};
  driver.offer(shot);
  deliver_waiting();
  CHECK_TRUE(frame.mid_exposure == shot.image.stamp);
  CHECK_TRUE(frame.first_data == shot.image.stamp);
  CHECK_TRUE(frame.dequeued == shot.image.stamp);
  CHECK_TRUE(frame.clock == hal::ClockId::device);
}

TEST(StreamCamera, PushesAllSettingsAtEveryAttempt) {
  settings.rate_hz = 20.0;
  settings.exposure_us = 1500.0;
  settings.gain = 7.0;
  settings.serial = "S1";
  start();
  deliver();
  driver.present = false;
  CHECK_TRUE(acquire() == Status::device_lost);
  driver.present = true;
  CHECK_TRUE(camera->start() == Status::ok);
  LONGS_EQUAL(2, driver.opened_with.size());
  const CameraSettings& again = driver.opened_with[1];
  STRCMP_EQUAL("/dev/video7", again.device.c_str());
  STRCMP_EQUAL("S1", again.serial.c_str());
  DOUBLES_EQUAL(20.0, again.rate_hz, 0.0);
  DOUBLES_EQUAL(1500.0, again.exposure_us, 0.0);
  DOUBLES_EQUAL(7.0, again.gain, 0.0);
  LONGS_EQUAL(1, driver.closes);
}

TEST(StreamCamera, WaitsBetweenAttemptsThatFail) {
  options.longest_retry = Duration{300 * ms};
  driver.present = false;
  driver.open_answer = Status::no_data;
  build();
  Duration longest;
  for (int k = 0; k < 5000; ++k) {  // as a loop of 1 kHz
    CHECK_TRUE(camera->start() == Status::no_data);
    longest = std::max(longest, camera->until_next_attempt());
    pass(1);
  }
  const std::vector<Time>& at = driver.opened_at;
  CHECK_TRUE(at.size() >= 16 && at.size() <= 20);
  check_ns(50 * ms, (at[1] - at[0]).ns);
  check_ns(100 * ms, (at[2] - at[1]).ns);
  check_ns(200 * ms, (at[3] - at[2]).ns);
  check_ns(300 * ms, (at[4] - at[3]).ns);
  check_ns(300 * ms, (at.back() - at[at.size() - 2]).ns);
  CHECK_TRUE(longest == options.longest_retry);
  STRCMP_EQUAL("/dev/video7: not there", camera->problem().c_str());
  LONGS_EQUAL(at.size(), camera->counts().attempts);
  // Back within the longest pause.
  driver.present = true;
  pass(300);
  CHECK_TRUE(camera->start() == Status::ok);
  LONGS_EQUAL(0, camera->counts().reconnects);  // it never was there before
}

TEST(StreamCamera, ASlowAttemptIsFollowedByTheWholePause) {
  driver.present = false;
  driver.open_takes = Duration{900 * ms};
  build();
  CHECK_TRUE(camera->start() != Status::ok);
  CHECK_TRUE(camera->until_next_attempt() == options.shortest_retry);
}

TEST(StreamCamera, StopAndStartDoNotShortenThePause) {
  driver.present = false;
  build();
  for (int k = 0; k < 100; ++k) {
    CHECK_TRUE(camera->stop() == Status::ok);
    CHECK_TRUE(camera->start() != Status::ok);
  }
  LONGS_EQUAL(1, driver.opened_with.size());
}

TEST(StreamCamera, ADeviceThatOpensButIsLostAtOnceIsNotOpenedAllTheTime) {
  start();
  for (int k = 0; k < 1000; ++k) {
    driver.present = false;  // open, but every take() fails
    CHECK_TRUE(acquire() == Status::device_lost);
    driver.present = true;
    static_cast<void>(camera->start());  // mostly too early
    pass(1);
  }
  CHECK_TRUE(driver.opened_with.size() <= 8);
}

TEST(StreamCamera, SilenceOfAFreeRunningCameraIsALoss) {
  start();
  deliver();
  for (int k = 0; k < 199; ++k) CHECK_TRUE(acquire() == Status::timeout);
  CHECK_TRUE(acquire() == Status::device_lost);  // 200 * 5 ms
  CHECK_TRUE(says("/dev/video7: no frame for 1000 ms"));
  CHECK_FALSE(driver.is_open());
  LONGS_EQUAL(1, camera->counts().losses);
  CHECK_TRUE(camera->start() == Status::ok);
  LONGS_EQUAL(1, camera->counts().reconnects);
  // The first frame may take longer.
  for (int k = 0; k < 599; ++k) CHECK_TRUE(acquire() == Status::timeout);
  CHECK_TRUE(acquire() == Status::device_lost);
}

TEST(StreamCamera, ASlowRateStretchesTheSilenceAllowed) {
  settings.rate_hz = 0.5;
  start();
  deliver();
  for (int k = 0; k < 1199; ++k) CHECK_TRUE(acquire() == Status::timeout);
  CHECK_TRUE(acquire() == Status::device_lost);  // three periods of 2 s
}

TEST(StreamCamera, SilenceBetweenEdgesOfATriggerLineIsNone) {
  settings.trigger = Trigger::line;
  start();
  deliver();
  for (int k = 0; k < 12; ++k) {
    pass(10'000);
    CHECK_TRUE(acquire() == Status::timeout);
  }
  CHECK_TRUE(camera->is_streaming());
}

TEST(StreamCamera, DamagedFramesAreNoSilence) {
  start();
  for (int k = 0; k < 20; ++k) {
    pass(400);
    driver.offer_damaged();
    CHECK_TRUE(acquire() == Status::incomplete);
    CHECK_TRUE(acquire() == Status::timeout);
  }
}

TEST(StreamCamera, SoftwareTriggerAsksForOneFrameAtATime) {
  settings.trigger = Trigger::software;
  start();
  CHECK_TRUE(acquire() == Status::timeout);
  CHECK_TRUE(acquire() == Status::timeout);
  LONGS_EQUAL(1, driver.triggers);
  deliver();
  LONGS_EQUAL(1, driver.triggers);
  pass(60'000);  // nobody asked in between: no silence
  CHECK_TRUE(acquire() == Status::timeout);
  LONGS_EQUAL(2, driver.triggers);
  pass(500);
  CHECK_TRUE(acquire() == Status::timeout);  // repeated
  LONGS_EQUAL(3, driver.triggers);
  pass(500);
  CHECK_TRUE(acquire() == Status::device_lost);
  CHECK_TRUE(camera->start() == Status::ok);
  driver.trigger_answer = Status::io_error;
  CHECK_TRUE(acquire() == Status::device_lost);
  CHECK_TRUE(says("no trigger"));
}

TEST(StreamCamera, WhateverADriverCannotExplainIsALoss) {
  for (const Status status : {Status::io_error, Status::device_lost, Status::incomplete, Status::unsupported}) {
    start();
    deliver();
    driver.offer_status(status);
    CHECK_TRUE(acquire() == Status::device_lost);
    CHECK_TRUE(says(to_string(status)));
    CHECK_FALSE(driver.is_open());
    CHECK_TRUE(camera->start() == Status::ok);
    deliver();
    camera.reset();
  }
}

TEST(StreamCamera, AFrameInHandIsCountedWhenTheDeviceIsLost) {
  start();
  driver.offer_good();
  driver.offer_status(Status::device_lost);
  CHECK_TRUE(acquire() == Status::device_lost);
  LONGS_EQUAL(1, camera->counts().skipped);
  CHECK_FALSE(driver.is_open());
}

TEST(StreamCamera, AnotherSizeThanAskedForIsALoss) {
  start();
  ScriptedDriver::Shot shot = driver.shot();
  shot.image.width_px = 6;
  driver.offer(shot);
  CHECK_TRUE(acquire() == Status::device_lost);
  STRCMP_EQUAL("/dev/video7: an image of 6 x 4 came, 8 x 4 was asked for", camera->problem().c_str());
}

TEST(StreamCamera, RowsThatDoNotFitAreALoss) {
  start();
  ScriptedDriver::Shot shot = driver.shot();
  shot.image.stride_bytes = 7;
  driver.offer(shot);
  CHECK_TRUE(acquire() == Status::device_lost);
  CHECK_TRUE(says("rows of 7 bytes came"));
}

TEST(StreamCamera, ADeeperFormatThanAskedForIsALoss) {
  settings.format = "grey8";
  driver.format = RawFormat::y12p;
  start();
  driver.offer_good();
  CHECK_TRUE(acquire() == Status::device_lost);
  CHECK_TRUE(says("y12p, grey8 was asked for"));
}

TEST(StreamCamera, ABufferNotTakenBackIsALoss) {
  start();
  driver.offer_good();
  CHECK_TRUE(acquire() == Status::ok);
  driver.give_back_answer = Status::io_error;
  CHECK_TRUE(camera->release(frame) == Status::ok);  // the lease is over
  CHECK_TRUE(camera->release(frame) == Status::stale_handle);
  CHECK_TRUE(acquire() == Status::device_lost);
  CHECK_TRUE(says("took no buffer back"));
}

TEST(StreamCamera, LeasesOutliveALoss) {
  start();
  driver.offer_good();
  CHECK_TRUE(acquire() == Status::ok);
  const hal::Frame held = frame;
  driver.present = false;
  CHECK_TRUE(acquire() == Status::device_lost);
  CHECK_TRUE(driver.is_open());  // the pixels are in its memory
  for (std::size_t k = 0; k < 32; ++k) LONGS_EQUAL(1, held.pixels[k]);
  CHECK_TRUE(camera->start() == Status::no_capacity);
  CHECK_TRUE(says("1 images of the former stream"));
  driver.present = true;
  CHECK_TRUE(camera->release(held) == Status::ok);
  CHECK_FALSE(driver.is_open());
  CHECK_TRUE(camera->start() == Status::ok);
  LONGS_EQUAL(1, deliver().sequence);
}

TEST(StreamCamera, CopiedLeasesOutliveALossAndANewStart) {
  options.always_copy = true;
  start();
  driver.offer_good();
  CHECK_TRUE(acquire() == Status::ok);
  const hal::Frame held = frame;
  driver.present = false;
  CHECK_TRUE(acquire() == Status::device_lost);
  driver.present = true;
  CHECK_TRUE(camera->start() == Status::ok);
  deliver();
  for (std::size_t k = 0; k < 32; ++k) LONGS_EQUAL(1, held.pixels[k]);
  CHECK_TRUE(camera->release(held) == Status::ok);
}

TEST(StreamCamera, StopClosesWhenTheLastLeaseIsBack) {
  start();
  driver.offer_good();
  CHECK_TRUE(acquire() == Status::ok);
  CHECK_TRUE(camera->stop() == Status::ok);
  CHECK_TRUE(driver.is_open());
  CHECK_TRUE(camera->release(frame) == Status::ok);
  CHECK_FALSE(driver.is_open());
  CHECK_TRUE(camera->stop() == Status::ok);
  LONGS_EQUAL(1, driver.closes);
}

TEST(StreamCamera, AHundredLossesLeaveNothingBehind) {
  options.leases = 4;
  start();
  std::uint32_t last = 0;
  for (std::uint32_t cycle = 0; cycle < 100; ++cycle) {
    for (std::uint32_t k = 0; k < 5; ++k) {
      const std::uint32_t sequence = deliver().sequence;
      CHECK_TRUE(sequence > last || (cycle == 0 && k == 0));
      last = sequence;
    }
    std::vector<hal::Frame> held;
    for (std::uint32_t k = 0; k < cycle % 4; ++k) {
      driver.offer_good();
      CHECK_TRUE(acquire() == Status::ok);
      held.push_back(frame);
      last = frame.sequence;
    }
    driver.underruns_seen = 2;
    driver.present = false;
    CHECK_TRUE(acquire() == Status::device_lost);
    for (const hal::Frame& h : held) CHECK_TRUE(camera->release(h) == Status::ok);
    CHECK_FALSE(driver.is_open());
    LONGS_EQUAL(0, driver.loans());
    CHECK_TRUE(camera->stop() == Status::ok);  // as the flight loop does
    CHECK_TRUE(camera->start() != Status::ok);
    driver.present = true;
    driver.underruns_seen = 0;
    const Time back = clock.peek();
    while (camera->start() != Status::ok) pass(1);
    CHECK_TRUE((clock.peek() - back).ns <= 50 * ms);
  }
  const StreamCounts counts = camera->counts();
  LONGS_EQUAL(100, counts.losses);
  LONGS_EQUAL(100, counts.reconnects);
  LONGS_EQUAL(201, counts.attempts);
  LONGS_EQUAL(200, counts.underruns);
  LONGS_EQUAL(100 * 5 + 25 * (0 + 1 + 2 + 3), counts.delivered);
  LONGS_EQUAL(100, driver.closes);
}

TEST(StreamCamera, SettingsThatCannotBeAreRefusedWithoutTheDevice) {
  const auto refused = [&](const char* why) {
    build();
    CHECK_TRUE(camera->start() == Status::invalid_argument);
    CHECK_TRUE(says(why));
    CHECK_TRUE(camera->problem().find("/dev/video7: ") == 0);
    LONGS_EQUAL(0, driver.opened_with.size());
  };
  settings.width_px = 0;
  refused("image size 0 x 4");
  settings.width_px = 0xFFFFFFFFU;
  refused("image size");
  settings.width_px = 8;
  settings.format = "mjpeg";
  refused("no pixel format \"mjpeg\"");
  settings.format.clear();
  settings.rate_hz = 100.0;
  settings.exposure_us = 10'001.0;
  refused("does not fit into a period");
}

TEST(StreamCamera, TakesNoHeapPerFrame) {
  for (const RawFormat format : {RawFormat::grey8, RawFormat::y10p}) {
    PreparedDriver prepared(format, clock);
    StreamCamera lean(prepared, clock, settings, options);
    CHECK_TRUE(lean.start() == Status::ok);
    std::size_t good = 0;
    std::size_t allocations = 0;
    {
      const test::AllocationTrap trap;
      for (int k = 0; k < 50; ++k) {
        prepared.waiting = k % 4;  // none, one, more than one; every fifth is damaged
        hal::Frame one;
        if (lean.acquire(wait, one) == Status::ok && lean.release(one) == Status::ok) ++good;
      }
      allocations = trap.allocations();
    }
    LONGS_EQUAL(0, allocations);
    CHECK_TRUE(good > 20);
    CHECK_TRUE(lean.counts().incomplete > 5);
    CHECK_TRUE(lean.counts().skipped > 20);
  }
}
