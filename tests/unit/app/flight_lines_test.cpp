// The flight loop with digital lines, and the ages of its frames.
#include <memory>

#include "tests/unit/app/loop_bench.hpp"

// After the rest: its macros replace new.
#include <CppUTest/TestHarness.h>

namespace {

using namespace relnav;
using telemetry::EventId;
using telemetry::SyncStatus;
using telemetry::TimePacket;
using test::LoopBench;
using test::period_ns;
using test::RenderedBox;

constexpr std::int64_t second = 1'000'000'000;
constexpr std::uint32_t heartbeat = 1;
constexpr std::uint32_t pps = 2;
constexpr std::uint32_t exposure = 5;
constexpr std::int64_t tai_seconds = 2'078'691'000;  // at clock 0

/// Rendered once, before the tests; 0.1 s apart.
struct Pictures {
  std::vector<RenderedBox::Pixels> box;
  Pictures() {
    const RenderedBox target(5);
    for (std::uint32_t i = 0; i < 14; ++i) box.push_back(target.render(0.1 * i, i));
  }
};
const Pictures pictures;

hal::Frame frame_at(std::uint32_t i, hal::ClockId clock) {
  hal::Frame f;
  f.pixels = pictures.box[i % pictures.box.size()].data();
  f.width_px = f.stride_bytes = RenderedBox::width_px;
  f.height_px = RenderedBox::height_px;
  f.mid_exposure = Time{i * period_ns};
  f.first_data = Time{i * period_ns + 3'000'000};
  f.sequence = i;
  f.clock = clock;
  return f;
}

}  // namespace

TEST_GROUP(FlightLines) {
  std::unique_ptr<LoopBench> owned = std::make_unique<LoopBench>(false, true);
  LoopBench& bench = *owned;

  void setup() override {
    bench.clock.set_tick({0});
    bench.config.lines.heartbeat = heartbeat;
    bench.config.lines.pulse = pps;
    bench.config.lines.exposure = exposure;
    bench.config.lines.time.tai_offset = Duration{tai_seconds * second + 300'000'000};
  }
  void teardown() override { LONGS_EQUAL(0, bench.undecodable()); }

  void configure() { CHECK_TRUE(bench.loop.configure(bench.config) == Status::ok); }
  void set_line(std::uint32_t line, bool level, std::int64_t time_ns) {
    CHECK_TRUE(bench.lines.drive(line, level, Time{time_ns}) == Status::ok);
  }
  /// A pulse whose edge is at this time, read by a step `age` later.
  /// Exposures of 10 ms, the middle 2 ms before the stamp; one pulse.
  void fly_with_exposures(std::int64_t pulse_ns) {
    configure();
    CHECK_TRUE(bench.loop.start() == Status::ok);
    for (std::uint32_t i = 0; i < 11; ++i) {
      const std::int64_t stamp = (i + 1) * period_ns;
      hal::Frame frame = frame_at(i, hal::ClockId::monotonic);
      frame.mid_exposure = Time{stamp};
      set_line(exposure, true, stamp - 7'000'000);
      set_line(exposure, false, stamp + 3'000'000);
      if (i == 9) set_line(pps, true, pulse_ns);
      bench.clock.jump_to(Time{stamp + 30'000'000});
      CHECK_TRUE(bench.feed(frame).status == Status::ok);
    }
  }
  void pulse(std::int64_t time_ns, std::int64_t age_ns = 20'000'000) {
    set_line(pps, true, time_ns);
    set_line(pps, false, time_ns + 100'000);
    bench.clock.jump_to(Time{time_ns + age_ns});
    static_cast<void>(bench.step());
  }
  std::size_t calls(platform::host::GpioCall::Kind kind) const {
    std::size_t count = 0;
    for (const auto& call : bench.lines.calls()) count += call.kind == kind ? 1U : 0U;
    return count;
  }
};

// ---- heartbeat ----

TEST(FlightLines, HeartbeatChangesOnceAStepInStandbyToo) {
  configure();
  bool level = bench.lines.level(heartbeat);
  for (int i = 0; i < 5; ++i) {
    static_cast<void>(bench.step());
    CHECK_TRUE(bench.lines.level(heartbeat) != level);
    level = !level;
  }
  CHECK_TRUE(bench.loop.start() == Status::ok);
  static_cast<void>(bench.step());
  CHECK_TRUE(bench.lines.level(heartbeat) != level);
  LONGS_EQUAL(6, calls(platform::host::GpioCall::Kind::set));
}

TEST(FlightLines, ALineThatFailsIsSaidOnceAndRequestedAnew) {
  configure();
  static_cast<void>(bench.step());
  bench.lines.lose_device();
  for (int i = 0; i < 5; ++i) static_cast<void>(bench.step());
  const auto events = bench.events(EventId::line_failed);
  CHECK_TRUE(!events.empty());
  LONGS_EQUAL(static_cast<long>(Status::device_lost), events[0].status);
  bench.lines.restore_device();
  static_cast<void>(bench.step());
  const bool level = bench.lines.level(heartbeat);
  static_cast<void>(bench.step());
  CHECK_TRUE(bench.lines.level(heartbeat) != level);
  for (std::int64_t n = 1; n <= 2; ++n) pulse(n * second);
  LONGS_EQUAL(2, bench.packets<TimePacket>().size());
  LONGS_EQUAL(events.size(), bench.events(EventId::line_failed).size());
}

TEST(FlightLines, ALineThatCannotBeHadRefusesTheConfiguration) {
  bench.config.lines.pulse = 8;  // there are 8
  CHECK_TRUE(bench.loop.configure(bench.config) == Status::invalid_argument);
  const auto events = bench.events(EventId::configuration_refused);
  LONGS_EQUAL(1, events.size());
  LONGS_EQUAL(static_cast<long>(app::ConfigItem::lines), events[0].args[0]);
  CHECK_TRUE(bench.loop.start() == Status::not_configured);
  // None is held any more.
  CHECK_TRUE(bench.lines.request_output(heartbeat, false) == Status::ok);
  CHECK_TRUE(bench.lines.release(heartbeat) == Status::ok);
  bench.config.lines.pulse = pps;
  configure();
  configure();  // gives its own lines back first
}

// ---- time ----

TEST(FlightLines, EachPulseGivesATimePacket) {
  configure();
  for (std::int64_t n = 1; n <= 6; ++n) pulse(n * (second + 20'000));
  const auto times = bench.packets<TimePacket>();
  LONGS_EQUAL(6, times.size());
  for (std::size_t i = 0; i < 6; ++i) {
    const auto n = static_cast<std::int64_t>(i + 1);
    LONGS_EQUAL(i + 1, times[i].pulses_used);
    LONGS_EQUAL(20, times[i].pulse_age_ms);
    CHECK_TRUE(times[i].tai_ns == static_cast<std::uint64_t>((tai_seconds + n) * second));
    LONGS_EQUAL(static_cast<long>(i < 3 ? SyncStatus::coarse : SyncStatus::locked), times[i].sync);
  }
  LONGS_EQUAL(20'000, times[5].drift_ppb);
  LONGS_EQUAL(6 * (second + 20'000), times[5].time_ns);
  LONGS_EQUAL(0, times[5].residual_ns);
  LONGS_EQUAL(20'000, times[1].residual_ns);  // while the drift is not known
  LONGS_EQUAL(0, times[5].seconds_source);
  const auto events = bench.events(EventId::time_synchronised);
  LONGS_EQUAL(1, events.size());
  LONGS_EQUAL(20'000, events[0].args[0]);
  LONGS_EQUAL(4, events[0].args[2]);
}

TEST(FlightLines, PulsesThatStayAwayAreSaidOnce) {
  configure();
  for (std::int64_t n = 1; n <= 5; ++n) pulse(n * second);
  for (std::int64_t t = 5 * second; t < 12 * second; t += 100'000'000) {
    bench.clock.jump_to(Time{t});
    static_cast<void>(bench.step());
  }
  const auto events = bench.events(EventId::time_lost);
  LONGS_EQUAL(1, events.size());
  CHECK_TRUE(events[0].args[0] > 2500 && events[0].args[0] <= 2600);
  LONGS_EQUAL(6, bench.packets<TimePacket>().size());
  LONGS_EQUAL(static_cast<long>(SyncStatus::holdover), bench.packets<TimePacket>().back().sync);
  pulse(12 * second);
  const auto last = bench.packets<TimePacket>().back();
  LONGS_EQUAL(static_cast<long>(SyncStatus::locked), last.sync);
  LONGS_EQUAL(6, last.pulses_missed);
  LONGS_EQUAL(2, bench.events(EventId::time_synchronised).size());
}

TEST(FlightLines, PulsesThatMoveAreSaid) {
  configure();
  for (std::int64_t n = 1; n <= 5; ++n) pulse(n * second);
  for (std::int64_t n = 6; n <= 8; ++n) pulse(n * second + 400'000'000);
  const auto events = bench.events(EventId::time_jumped);
  LONGS_EQUAL(1, events.size());
  LONGS_EQUAL(400'000'000, events[0].args[0]);
  LONGS_EQUAL(6, bench.packets<TimePacket>().size());
  LONGS_EQUAL(2, bench.packets<TimePacket>().back().pulses_refused);
}

TEST(FlightLines, AStepReadsABoundedNumberOfEdges) {
  configure();
  for (int i = 0; i < 100; ++i) set_line(exposure, i % 2 == 0, 1000 * (i + 1));
  std::size_t read = 0;
  for (int i = 0; i < 5; ++i) {
    static_cast<void>(bench.step());
    const std::size_t now = calls(platform::host::GpioCall::Kind::wait_edge);
    CHECK_TRUE(now - read <= 32);
    read = now;
  }
  LONGS_EQUAL(100 + 2, read);  // the last two found nothing more
}

TEST(FlightLines, EdgesOfAnotherClockAreNotUsed) {
  LoopBench other(false, true);
  platform::host::ScriptedClock tai(Time{0}, hal::ClockId::tai);
  app::FlightLoop loop(other.camera, tai, other.link, other.watchdog, nullptr, {&other.lines, nullptr});
  CHECK_TRUE(loop.configure(bench.config) == Status::ok);
  CHECK_TRUE(other.lines.drive(pps, true, Time{second}) == Status::ok);  // monotonic
  static_cast<void>(loop.step());
  LONGS_EQUAL(0, other.packets<TimePacket>().size());
  LONGS_EQUAL(static_cast<long>(Status::unsupported), other.events(EventId::line_failed).at(0).status);
}

TEST(FlightLines, StampsAreHeldAgainstTheExposureLine) {
  fly_with_exposures(second + 10'000'000);
  LONGS_EQUAL(1, bench.packets<TimePacket>().size());
  LONGS_EQUAL(2'000'000, bench.packets<TimePacket>()[0].exposure_offset_ns);
}

TEST(FlightLines, AnExposureThatEndsAfterThePulseIsToldOfToo) {
  fly_with_exposures(second - 1'000'000);
  LONGS_EQUAL(1, bench.packets<TimePacket>().size());
  LONGS_EQUAL(2'000'000, bench.packets<TimePacket>()[0].exposure_offset_ns);
}

TEST(FlightLines, EachPulseIsToldOfHoweverLateItIsRead) {
  configure();
  for (std::int64_t n = 1; n <= 3; ++n) {
    set_line(pps, true, n * second);
    set_line(pps, false, n * second + 100'000'000);
  }
  bench.clock.jump_to(Time{3 * second + 200'000'000});
  static_cast<void>(bench.step());
  const auto told = bench.packets<TimePacket>();
  LONGS_EQUAL(3, told.size());
  for (std::size_t k = 0; k < told.size(); ++k) {
    LONGS_EQUAL(k + 1, told[k].pulses_used);
    LONGS_EQUAL((k + 1) * second, told[k].time_ns);
  }
}

TEST(FlightLines, WithoutLinesNothingChanges) {
  LoopBench plain;
  bench.config.lines = {};
  for (LoopBench* b : {&plain, &bench}) {
    b->clock.set_tick({1000});
    CHECK_TRUE(b->begin() == Status::ok);
    for (std::uint32_t i = 0; i < 12; ++i) {
      CHECK_TRUE(b->feed(frame_at(i, hal::ClockId::monotonic)).status == Status::ok);
    }
  }
  CHECK_TRUE(plain.bytes_sent() == bench.bytes_sent());
  LONGS_EQUAL(plain.clock.peek().ns, bench.clock.peek().ns);
  LONGS_EQUAL(0, bench.lines.calls().size());
}

// ---- latency ----

TEST_GROUP(FlightLatency) {
  std::unique_ptr<LoopBench> owned = std::make_unique<LoopBench>();
  LoopBench& bench = *owned;

  /// One step that takes no time, so long after mid-exposure.
  void step_after(std::uint32_t i, std::int64_t age_ns, hal::ClockId clock = hal::ClockId::monotonic) {
    bench.clock.jump_to(Time{i * period_ns + age_ns});
    CHECK_TRUE(bench.feed(frame_at(i, clock)).status == Status::ok);
  }
  void check_health(std::uint32_t latest, std::uint32_t largest, std::uint32_t arrival, std::uint32_t arrival_largest) {
    const auto health = bench.packets<telemetry::HealthPacket>().back();
    LONGS_EQUAL(latest, health.latency_us);
    LONGS_EQUAL(largest, health.latency_max_us);
    LONGS_EQUAL(arrival, health.arrival_latency_us);
    LONGS_EQUAL(arrival_largest, health.arrival_latency_max_us);
  }
  void setup() override {
    bench.clock.set_tick({0});
    bench.config.health_every_frames = 3;
    CHECK_TRUE(bench.begin() == Status::ok);
  }
};

TEST(FlightLatency, IsThatOfTheLatestFrameAndTheLargestSinceTheLastHealth) {
  step_after(0, 12'000'000);
  check_health(12'000, 12'000, 9'000, 9'000);
  step_after(1, 40'000'000);
  step_after(2, 10'000'000);
  step_after(3, 11'000'999);
  check_health(11'000, 40'000, 8'000, 37'000);
  for (std::uint32_t i = 4; i < 7; ++i) step_after(i, 5'000'000);
  check_health(5'000, 5'000, 2'000, 2'000);
}

TEST(FlightLatency, IsNotNegativeAndSaturates) {
  step_after(0, -1'000'000);
  check_health(0, 0, 0, 0);
  for (std::uint32_t i = 1; i < 4; ++i) step_after(i, 5'000'000'000'000);
  check_health(0xFFFFFFFF, 0xFFFFFFFF, 0xFFFFFFFF, 0xFFFFFFFF);
}

TEST(FlightLatency, OfAnotherClockIsNotMeasured) {
  step_after(0, 12'000'000);
  for (std::uint32_t i = 1; i < 4; ++i) step_after(i, 12'000'000, hal::ClockId::device);
  check_health(0, 0, 0, 0);
}
