#include "fsw/app/flight_loop.hpp"

#include <limits>
#include <memory>

#include "tests/unit/app/loop_bench.hpp"

// After the rest: its macros replace new.
#include <CppUTest/TestHarness.h>

namespace {

using namespace relnav;
using app::Mode;
using telemetry::EventId;
using test::LoopBench;
using test::period_ns;
using test::RenderedBox;

/// Rendered once, before the tests.
struct Pictures {
  std::vector<RenderedBox::Pixels> box;    ///< 0.1 s apart
  std::vector<RenderedBox::Pixels> other;  ///< unrelated to each other, with corners
  Pictures() {
    const RenderedBox target(5);
    for (std::uint32_t i = 0; i < 40; ++i) box.push_back(target.render(0.1 * i, i));
    for (std::uint32_t i = 0; i < 12; ++i) {
      other.push_back(RenderedBox(100 + i, {.phi0 = Vec3(0.7 * i, -0.5 * i, 0.3 * i)}).render(0.0, i));
    }
  }
};
const Pictures pictures;

}  // namespace

TEST_GROUP(FlightLoop) {
  // Not a plain member: CppUTest's new knows nothing of the loop's alignment.
  std::unique_ptr<LoopBench> owned = std::make_unique<LoopBench>();
  LoopBench& bench = *owned;
  std::uint32_t next = 0;  // picture, sequence number and period of the next good frame

  void teardown() override {
    LONGS_EQUAL(0, bench.undecodable());
    LONGS_EQUAL(0, bench.camera.leases_out());
    LONGS_EQUAL(bench.steps, bench.watchdog.kicks());
  }
  void begin() { CHECK_TRUE(bench.begin() == Status::ok); }
  const app::StepReport& good() {
    const std::uint32_t i = next++;
    return bench.feed(pictures.box[i % pictures.box.size()], i * period_ns, i);
  }
  void reach_track() {
    begin();
    for (int i = 0; i < 15 && bench.loop.mode() != Mode::track; ++i) CHECK_TRUE(good().status == Status::ok);
    CHECK_TRUE(bench.loop.mode() == Mode::track);
  }
  hal::Frame good_frame() {
    const std::uint32_t i = next++;
    hal::Frame f;
    f.pixels = pictures.box[i % pictures.box.size()].data();
    f.width_px = f.stride_bytes = RenderedBox::width_px;
    f.height_px = RenderedBox::height_px;
    f.mid_exposure = Time{i * period_ns};
    f.sequence = i;
    return f;
  }
  /// One frame is refused with this status and event; the next good one is used again.
  void check_refused(const hal::Frame& frame, Status status, EventId id) {
    const auto processed = bench.packets<telemetry::RelStatePacket>().size();
    CHECK_TRUE(bench.feed(frame).status == status);
    LONGS_EQUAL(processed, bench.packets<telemetry::RelStatePacket>().size());
    LONGS_EQUAL(1, bench.events(id).size());
    CHECK_TRUE(bench.loop.mode() == Mode::track);
    CHECK_TRUE(good().status == Status::ok);
    CHECK_TRUE(bench.loop.mode() == Mode::track);
    LONGS_EQUAL(0, bench.loop.report().reset_counter);
  }
  void check_mode_event(std::size_t index, Mode from, Mode to) {
    const auto events = bench.events(EventId::mode_changed);
    CHECK_TRUE(index < events.size());
    LONGS_EQUAL(static_cast<long>(from), events[index].args[0]);
    LONGS_EQUAL(static_cast<long>(to), events[index].args[1]);
  }
};

// ---- modes ----

TEST(FlightLoop, StaysInStandbyUntilStarted) {
  CHECK_TRUE(bench.loop.start() == Status::not_configured);
  CHECK_TRUE(bench.step().status == Status::not_configured);
  CHECK_TRUE(bench.loop.configure(bench.config) == Status::ok);
  CHECK_TRUE(bench.step().status == Status::not_configured);
  CHECK_TRUE(bench.loop.mode() == Mode::standby);
  LONGS_EQUAL(0, bench.camera.calls().size());
}

TEST(FlightLoop, StaysInStandbyWhenTheCameraDoesNotStart) {
  CHECK_TRUE(bench.loop.configure(bench.config) == Status::ok);
  bench.camera.fail_starts(Status::io_error);
  CHECK_TRUE(bench.loop.start() == Status::io_error);
  CHECK_TRUE(bench.loop.mode() == Mode::standby);
  LONGS_EQUAL(1, bench.events(EventId::camera_lost).size());
  CHECK_TRUE(bench.loop.start() == Status::ok);
}

TEST(FlightLoop, AcquiresThenTracks) {
  begin();
  CHECK_TRUE(bench.loop.mode() == Mode::acquire);
  CHECK_TRUE(bench.loop.start() == Status::invalid_argument);
  CHECK_TRUE(bench.loop.configure(bench.config) == Status::invalid_argument);
  CHECK_TRUE(good().mode == Mode::acquire);
  CHECK_TRUE(good().mode == Mode::acquire);  // the start adjustment takes six frames
  for (int i = 0; i < 10; ++i) CHECK_TRUE(good().status == Status::ok);
  CHECK_TRUE(bench.loop.mode() == Mode::track);
  check_mode_event(0, Mode::standby, Mode::acquire);
  check_mode_event(1, Mode::acquire, Mode::track);
  LONGS_EQUAL(2, bench.events(EventId::mode_changed).size());
  LONGS_EQUAL(1, bench.events(EventId::track_acquired).size());
}

TEST(FlightLoop, StopReturnsToStandby) {
  reach_track();
  CHECK_TRUE(bench.loop.stop() == Status::ok);
  CHECK_TRUE(bench.loop.mode() == Mode::standby);
  CHECK_FALSE(bench.camera.streaming());
  CHECK_TRUE(bench.step().status == Status::not_configured);
  CHECK_TRUE(bench.loop.configure(bench.config) == Status::ok);
}

TEST(FlightLoop, LosesATargetThatIsNoLongerSeenAndFindsIt) {
  reach_track();
  const auto seen = next;
  int predicted = 0;
  for (std::uint32_t i = 0; i < 10; ++i) {
    CHECK_TRUE(bench.loop.mode() == Mode::track);
    const auto n = next++;
    const std::uint16_t inliers = bench.feed(pictures.other[i], n * period_ns, n).inliers;
    CHECK_TRUE(inliers < 4);
    if (bench.loop.mode() == Mode::lost) break;
    const auto flags = bench.packets<telemetry::RelStatePacket>().back().valid_flags;
    CHECK_EQUAL(inliers == 0, (flags & telemetry::valid::predicted) != 0);
    if (inliers == 0) ++predicted;
  }
  CHECK_TRUE(predicted > 0);
  CHECK_TRUE(bench.loop.mode() == Mode::lost);
  LONGS_EQUAL(1, bench.loop.report().reset_counter);
  LONGS_EQUAL(1, bench.events(EventId::track_lost).size());
  LONGS_EQUAL(10, bench.events(EventId::track_lost)[0].args[0]);
  LONGS_EQUAL(1, bench.events(EventId::filter_reset).size());
  const auto last = bench.packets<telemetry::RelStatePacket>().back();
  LONGS_EQUAL(0, last.valid_flags);
  DOUBLES_EQUAL(0.0, last.t_CT[2], 0.0);

  CHECK_TRUE(good().status == Status::ok);
  CHECK_TRUE(bench.loop.mode() == Mode::acquire);
  check_mode_event(2, Mode::track, Mode::lost);
  check_mode_event(3, Mode::lost, Mode::acquire);
  for (int i = 0; i < 12; ++i) CHECK_TRUE(good().status == Status::ok);
  CHECK_TRUE(bench.loop.mode() == Mode::track);
  LONGS_EQUAL(1, bench.loop.report().reset_counter);
  CHECK_TRUE(next > seen);
}

TEST(FlightLoop, StaysInAcquireOnAnImageWithoutEnoughCorners) {
  RenderedBox::Pixels ramp(pictures.box[0].size());
  begin();
  for (std::uint32_t i = 0; i < 12; ++i) {
    for (std::size_t k = 0; k < ramp.size(); ++k) ramp[k] = static_cast<std::uint8_t>((k % 320) / 2 + i);
    CHECK_TRUE(bench.feed(ramp, i * period_ns, i).status == Status::too_few_features);
    CHECK_TRUE(bench.loop.mode() == (i < 9 ? Mode::acquire : Mode::lost));
    next = i + 1;
  }
  LONGS_EQUAL(1, bench.events(EventId::too_few_features).size());
  LONGS_EQUAL(0, bench.loop.report().reset_counter);  // there was no estimate to jump
  CHECK_TRUE(good().mode == Mode::acquire);
}

// ---- bad frames ----

TEST(FlightLoop, RefusesAFrameOfAnotherSize) {
  reach_track();
  hal::Frame frame = good_frame();
  frame.width_px = 160;
  check_refused(frame, Status::invalid_argument, EventId::frame_refused_size);
}

TEST(FlightLoop, RefusesARowShorterThanTheImage) {
  reach_track();
  hal::Frame frame = good_frame();
  frame.stride_bytes = 319;
  check_refused(frame, Status::invalid_argument, EventId::frame_refused_size);
}

TEST(FlightLoop, RefusesAFrameWithoutPixels) {
  reach_track();
  hal::Frame frame = good_frame();
  frame.pixels = nullptr;
  check_refused(frame, Status::invalid_argument, EventId::frame_refused_size);
}

TEST(FlightLoop, RefusesSixteenBits) {
  reach_track();
  hal::Frame frame = good_frame();
  frame.format = hal::PixelFormat::mono16;
  check_refused(frame, Status::unsupported, EventId::frame_refused_format);
}

TEST(FlightLoop, RefusesARepeatedTimeStamp) {
  reach_track();
  hal::Frame frame = good_frame();
  frame.mid_exposure = Time{frame.mid_exposure.ns - period_ns};
  check_refused(frame, Status::out_of_order, EventId::frame_refused_out_of_order);
}

TEST(FlightLoop, RefusesATimeStampThatGoesBack) {
  reach_track();
  hal::Frame frame = good_frame();
  frame.mid_exposure = Time{0};
  check_refused(frame, Status::out_of_order, EventId::frame_refused_out_of_order);
}

TEST(FlightLoop, RefusesTimeStampsThatNoPacketCanCarry) {
  reach_track();
  hal::Frame frame = good_frame();
  frame.mid_exposure = Time{-1};
  check_refused(frame, Status::outside_domain, EventId::frame_refused_out_of_order);
  frame = good_frame();
  frame.mid_exposure = Time{std::numeric_limits<std::int64_t>::max()};
  CHECK_TRUE(bench.feed(frame).status == Status::outside_domain);
  CHECK_TRUE(good().status == Status::ok);
}

TEST(FlightLoop, RefusesOldFramesWhenAnAgeIsSet) {
  bench.config.frames.max_age = Duration{500};
  bench.config.navigator.filter.start_frames = 2;
  begin();
  bench.clock.jump_to(Time{1'000'000'000});
  CHECK_TRUE(good().status == Status::timeout);
  LONGS_EQUAL(1, bench.events(EventId::frame_refused_age).size());
  hal::Frame other_clock = good_frame();
  other_clock.clock = hal::ClockId::device;
  CHECK_TRUE(bench.feed(other_clock).status == Status::ok);
}

TEST(FlightLoop, GoesToLostWhenStampsStandStillAndStaysThere) {
  reach_track();
  const std::int64_t stuck = (next - 1) * period_ns;
  for (int i = 0; i < 40; ++i) {
    hal::Frame frame = good_frame();
    frame.mid_exposure = Time{stuck};
    CHECK_TRUE(bench.feed(frame).status == Status::out_of_order);
  }
  CHECK_TRUE(bench.loop.mode() == Mode::lost);
  LONGS_EQUAL(1, bench.loop.report().reset_counter);
  const auto events = bench.events(EventId::frame_refused_out_of_order);
  LONGS_EQUAL(2, events.size());  // 40 happenings, one report in 30 frames
  LONGS_EQUAL(29, events[1].suppressed);
  LONGS_EQUAL(31, events[1].occurrence);
}

TEST(FlightLoop, TakesUpANewTimeBaseAfterBeingLost) {
  reach_track();
  const std::uint32_t first = next;
  for (std::uint32_t i = 0; i < 11; ++i) {
    hal::Frame frame = good_frame();
    frame.mid_exposure = Time{(next - first) * period_ns / 2};  // an earlier clock, running
    const Status status = bench.feed(frame).status;
    CHECK_TRUE(status == (i < 10 ? Status::out_of_order : Status::ok));
  }
  CHECK_TRUE(bench.loop.mode() == Mode::acquire);
}

TEST(FlightLoop, ReportsAGapInSequenceAndGoesOn) {
  reach_track();
  next += 2;
  CHECK_TRUE(good().status == Status::ok);
  const auto gaps = bench.events(EventId::frame_gap);
  LONGS_EQUAL(1, gaps.size());
  LONGS_EQUAL(2, gaps[0].args[2]);
  CHECK_TRUE(bench.loop.mode() == Mode::track);
}

TEST(FlightLoop, ReportsAGapInTimeAndGoesOn) {
  reach_track();
  hal::Frame frame = good_frame();
  frame.mid_exposure = Time{frame.mid_exposure.ns + 20 * period_ns};
  CHECK_TRUE(bench.feed(frame).status == Status::ok);
  const auto gaps = bench.events(EventId::frame_gap);
  LONGS_EQUAL(1, gaps.size());
  LONGS_EQUAL(20, gaps[0].args[2]);
  LONGS_EQUAL(0, bench.loop.report().reset_counter);
}

TEST(FlightLoop, StartsAnewAfterALongGap) {
  reach_track();
  hal::Frame frame = good_frame();
  frame.mid_exposure = Time{frame.mid_exposure.ns + 31'000'000'000};
  CHECK_TRUE(bench.feed(frame).status == Status::ok);
  CHECK_TRUE(bench.loop.mode() == Mode::acquire);
  LONGS_EQUAL(1, bench.loop.report().reset_counter);
  LONGS_EQUAL(1, bench.events(EventId::filter_reset).size());
  check_mode_event(2, Mode::track, Mode::lost);
  check_mode_event(3, Mode::lost, Mode::acquire);
}

TEST(FlightLoop, DoesNotUseImagesWithoutContrast) {
  for (const int level : {0, 255, 90}) {
    LoopBench b;
    const RenderedBox::Pixels flat(pictures.box[0].size(), static_cast<std::uint8_t>(level));
    CHECK_TRUE(b.begin() == Status::ok);
    for (std::uint32_t i = 0; i < 45; ++i) {
      CHECK_TRUE(b.feed(flat, i * period_ns, i).status == Status::incomplete);
      CHECK_TRUE(b.loop.mode() == (i < 9 ? Mode::acquire : Mode::lost));
    }
    const auto events = b.events(EventId::image_without_contrast);
    LONGS_EQUAL(1, events.size());
    LONGS_EQUAL(level, events[0].args[0]);
    LONGS_EQUAL(0, b.undecodable());
    LONGS_EQUAL(0, b.camera.leases_out());
  }
}

TEST(FlightLoop, DoesNotUseAFrozenImage) {
  reach_track();
  const auto& last = pictures.box[(next - 1) % pictures.box.size()];
  for (int i = 0; i < 45; ++i) {
    const std::uint32_t n = next++;
    CHECK_TRUE(bench.feed(last, n * period_ns, n).status == Status::incomplete);
    CHECK_TRUE(bench.loop.mode() == (i < 9 ? Mode::track : Mode::lost));
  }
  LONGS_EQUAL(1, bench.events(EventId::image_frozen).size());
  LONGS_EQUAL(1, bench.loop.report().reset_counter);
  CHECK_TRUE(good().mode == Mode::acquire);
}

TEST(FlightLoop, SurvivesIncompleteFrames) {
  reach_track();
  CHECK_TRUE(bench.camera.push_status(Status::incomplete) == Status::ok);
  CHECK_TRUE(bench.step().status == Status::incomplete);
  CHECK_TRUE(bench.camera.push_status(Status::io_error) == Status::ok);
  CHECK_TRUE(bench.step().status == Status::incomplete);
  LONGS_EQUAL(1, bench.events(EventId::frame_incomplete).size());
  CHECK_TRUE(good().status == Status::ok);
  CHECK_TRUE(bench.loop.mode() == Mode::track);
}

// ---- camera ----

TEST(FlightLoop, WaitsForFramesWithoutEffect) {
  reach_track();
  const auto packets = bench.link.size();
  CHECK_TRUE(bench.camera.push_status(Status::no_data) == Status::ok);
  CHECK_TRUE(bench.step().status == Status::no_data);
  CHECK_TRUE(bench.step().status == Status::timeout);
  LONGS_EQUAL(packets, bench.link.size());
  CHECK_TRUE(good().status == Status::ok);
  CHECK_TRUE(bench.loop.mode() == Mode::track);
}

TEST(FlightLoop, BringsALostCameraBack) {
  reach_track();
  CHECK_TRUE(bench.camera.push_status(Status::device_lost) == Status::ok);
  bench.camera.fail_starts(Status::device_lost, 3);
  for (int i = 0; i < 4; ++i) CHECK_TRUE(bench.step().status == Status::device_lost);
  CHECK_TRUE(good().status == Status::ok);
  CHECK_TRUE(bench.loop.mode() == Mode::track);
  LONGS_EQUAL(1, bench.events(EventId::camera_lost).size());
  const auto recovered = bench.events(EventId::camera_recovered);
  LONGS_EQUAL(1, recovered.size());
  LONGS_EQUAL(4, recovered[0].args[1]);
}

TEST(FlightLoop, GivesTheTargetUpWhenTheCameraStaysAway) {
  reach_track();
  CHECK_TRUE(bench.camera.push_status(Status::device_lost) == Status::ok);
  bench.camera.fail_starts(Status::device_lost, 1000);
  for (int i = 0; i < 100; ++i) CHECK_TRUE(bench.step().status == Status::device_lost);
  CHECK_TRUE(bench.loop.mode() == Mode::lost);
  const auto health = bench.packets<telemetry::HealthPacket>();
  LONGS_EQUAL(0, health.back().flags);
  LONGS_EQUAL(1, health.back().camera_losses);
  CHECK_TRUE(health.size() >= 10);
}

TEST(FlightLoop, TreatsASilentCameraAsLost) {
  reach_track();
  for (int i = 0; i < 99; ++i) CHECK_TRUE(bench.step().status == Status::timeout);
  CHECK_TRUE(bench.step().status == Status::device_lost);  // 100 waits of 50 ms
  CHECK_TRUE(bench.loop.mode() == Mode::lost);
  LONGS_EQUAL(1, bench.events(EventId::camera_lost).size());
  CHECK_TRUE(good().mode == Mode::acquire);
}

TEST(FlightLoop, StartsTheCameraAnewWhenALeaseCannotBeGivenBack) {
  LoopBench b;
  CHECK_TRUE(b.begin() == Status::ok);
  b.camera.fail_releases(Status::io_error);
  CHECK_TRUE(b.feed(pictures.box[0], 0, 0).status == Status::ok);
  LONGS_EQUAL(1, b.events(EventId::camera_lost).size());
  CHECK_TRUE(b.feed(pictures.box[1], period_ns, 1).status == Status::ok);
  LONGS_EQUAL(1, b.events(EventId::camera_recovered).size());
  LONGS_EQUAL(0, b.camera.leases_out());  // given back before the new start
}

// ---- telemetry, health ----

TEST(FlightLoop, SendsEachPacketAtItsRate) {
  begin();
  for (int i = 0; i < 20; ++i) CHECK_TRUE(good().status == Status::ok);
  const auto states = bench.packets<telemetry::RelStatePacket>();
  LONGS_EQUAL(20, states.size());
  LONGS_EQUAL(2, bench.packets<telemetry::FeaturesPacket>().size());
  LONGS_EQUAL(2, bench.packets<telemetry::HealthPacket>().size());
  using namespace telemetry::valid;
  for (std::size_t i = 0; i < states.size(); ++i) {
    LONGS_EQUAL(pose | pose_covariance | velocity | rate | rate_covariance, states[i].valid_flags);  // none predicted
    LONGS_EQUAL(i * 100'000'000, states[i].time_ns);
    LONGS_EQUAL(i, states[i].frame_sequence);
    CHECK_TRUE(states[i].q_CT[3] >= 0.0);
  }
}

TEST(FlightLoop, CountsPacketsThatTheLinkDoesNotTake) {
  reach_track();
  const auto before = bench.link.refused();
  CHECK_TRUE(bench.link.push_answer(Status::no_capacity, 2) == Status::ok);
  CHECK_TRUE(bench.link.push_answer(Status::io_error, 1) == Status::ok);
  for (int i = 0; i < 12; ++i) CHECK_TRUE(good().status == Status::ok);
  LONGS_EQUAL(before + 3, bench.link.refused());
  CHECK_TRUE(bench.events(EventId::telemetry_dropped).size() <= 1);
  LONGS_EQUAL(3, bench.packets<telemetry::HealthPacket>().back().telemetry_dropped);
}

TEST(FlightLoop, SurvivesALinkThatTakesNothing) {
  begin();
  CHECK_TRUE(bench.link.push_answer(Status::no_capacity, 100000) == Status::ok);
  for (int i = 0; i < 20; ++i) CHECK_TRUE(good().status == Status::ok);
  CHECK_TRUE(bench.loop.mode() == Mode::track);
}

TEST(FlightLoop, KicksEvenWhenTheWatchdogRefuses) {
  begin();
  bench.watchdog.fail_kicks(Status::device_lost, 1);
  CHECK_TRUE(good().status == Status::ok);
  CHECK_TRUE(bench.loop.watchdog_status() == Status::device_lost);
  CHECK_TRUE(good().status == Status::ok);
  CHECK_TRUE(bench.loop.watchdog_status() == Status::ok);
}

TEST(FlightLoop, MeasuresTheStages) {
  begin();
  const app::StageTimes& t = good().times;
  CHECK_TRUE(t.acquire_ns > 0 && t.telemetry_ns > 0 && t.detect_ns > 0);
  CHECK_TRUE(t.total_ns >= t.acquire_ns + t.telemetry_ns + t.detect_ns);
}

TEST(FlightLoop, TheClockDoesNotReachTheTelemetry) {
  LoopBench other;
  other.clock.jump_to(Time{123456789});
  other.clock.set_tick({77777});
  begin();
  CHECK_TRUE(other.begin() == Status::ok);
  for (std::uint32_t i = 0; i < 12; ++i) {
    hal::Frame frame = good_frame();
    frame.clock = hal::ClockId::device;  // as of a replay; what is of the clock's own scale has a latency
    CHECK_TRUE(bench.feed(frame).status == other.feed(frame).status);
  }
  CHECK_TRUE(bench.bytes_sent() == other.bytes_sent());
}

// ---- configuration ----

TEST(FlightLoop, RefusesBadConfigurations) {
  using app::ConfigItem;
  using app::FlightLoopConfig;
  struct Case {
    ConfigItem item;
    void (*spoil)(FlightLoopConfig&);
  };
  const Case cases[] = {
      {ConfigItem::camera, [](FlightLoopConfig& c) { c.camera.fu = 0.0; }},
      {ConfigItem::camera, [](FlightLoopConfig& c) { c.camera.width_px = 1025; }},
      {ConfigItem::camera, [](FlightLoopConfig& c) { c.camera.height_px = 1025; }},
      {ConfigItem::navigator, [](FlightLoopConfig& c) { c.navigator.filter.range_m = 0.0; }},
      {ConfigItem::packets, [](FlightLoopConfig& c) { c.packets.apid_base = 0; }},
      {ConfigItem::packets, [](FlightLoopConfig& c) { c.packets.epoch_offset_ns = -1; }},
      {ConfigItem::limits, [](FlightLoopConfig& c) { c.lost_after_frames = 0; }},
      {ConfigItem::limits, [](FlightLoopConfig& c) { c.acquire_wait = Duration{-1}; }},
      {ConfigItem::limits, [](FlightLoopConfig& c) { c.filter.max_test_ratio = std::nan(""); }},
      {ConfigItem::lines, [](FlightLoopConfig& c) { c.lines.pulse = -2; }},
      {ConfigItem::lines, [](FlightLoopConfig& c) { c.lines.pulse = c.lines.heartbeat = 3; }},
      {ConfigItem::lines, [](FlightLoopConfig& c) { c.lines.time.lock_pulses = 0; }},
  };
  for (const Case& one : cases) {
    LoopBench b;
    one.spoil(b.config);
    CHECK_TRUE(b.loop.configure(b.config) == Status::invalid_argument);
    b.config.packets = {};
    const auto events = b.events(EventId::configuration_refused);
    LONGS_EQUAL(1, events.size());
    LONGS_EQUAL(static_cast<long>(one.item), events[0].args[0]);
    CHECK_TRUE(b.loop.start() == Status::not_configured);
  }
}
