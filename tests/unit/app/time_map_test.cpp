#include "fsw/app/time_map.hpp"

#include <cstdint>
#include <cstdlib>
#include <limits>

#include "fsw/base/generator.hpp"

#include <CppUTest/TestHarness.h>

using namespace relnav;
using app::TimeMap;
using app::TimeMapConfig;
using telemetry::SecondsSource;
using telemetry::SyncStatus;
using Verdict = TimeMap::Verdict;

namespace {

constexpr std::int64_t second = 1'000'000'000;
constexpr std::int64_t start = 7'300'000'000;                // of the clock, at the first pulse
constexpr std::int64_t first_tai = 2'078'691'237;            // second of TAI since 1958 at the first pulse
constexpr std::int64_t offset = first_tai * second - start;  // of TAI to the clock

}  // namespace

TEST_GROUP(TimeMap) {
  TimeMap map;
  TimeMapConfig config;
  std::int64_t drift_ppb = 20'000;  // of the clock

  void setup() override {
    config.tai_offset = Duration{offset + 400'000'000};  // coarse
    map.configure(config);
  }
  /// By the clock, `tai_ns` after the first pulse: the truth.
  Time clock_at(std::int64_t tai_ns) const { return Time{start + tai_ns + tai_ns / second * drift_ppb}; }
  Time pulse(std::int64_t n) const { return clock_at(n * second); }
  void pulses(std::int64_t from, std::int64_t to) {
    for (std::int64_t n = from; n <= to; ++n) CHECK_TRUE(map.add(pulse(n)) == Verdict::used);
  }
  void check_tai(std::int64_t tai_ns, std::int64_t tolerance_ns) {
    const auto tai = map.to_tai(clock_at(tai_ns));
    CHECK_TRUE(tai.has_value());
    const std::int64_t error = tai.value().ns - (first_tai * second + tai_ns);
    CHECK_TRUE(std::abs(error) <= tolerance_ns);
    const auto back = map.to_clock(tai.value());
    CHECK_TRUE(std::abs(back.value().ns - clock_at(tai_ns).ns) <= 1);
  }
};

TEST(TimeMap, KnowsNothingBeforeThePulses) {
  CHECK_TRUE(map.status(Time{0}) == SyncStatus::none);
  CHECK_TRUE(map.to_tai(Time{0}).status() == Status::no_data);
  CHECK_TRUE(map.to_clock(Time{0}).status() == Status::no_data);
}

TEST(TimeMap, OnePulseGivesTheOffset) {
  pulses(0, 0);
  CHECK_TRUE(map.status(pulse(0)) == SyncStatus::coarse);
  CHECK_TRUE(map.latest_seconds() == first_tai);  // the configured offset is 0.4 s off
  CHECK_TRUE(map.seconds_source() == SecondsSource::configuration);
  check_tai(0, 0);
}

TEST(TimeMap, FindsTheDrift) {
  for (const std::int64_t truth : {20'000, -20'000, 0, 99'000, -99'000, 1}) {
    drift_ppb = truth;
    map.configure(config);
    pulses(0, 2);
    CHECK_TRUE(map.status(pulse(2)) == SyncStatus::coarse);
    pulses(3, 100);
    CHECK_TRUE(map.status(pulse(100)) == SyncStatus::locked);
    LONGS_EQUAL(truth, map.drift_ppb());
    LONGS_EQUAL(0, map.residual().ns);
    CHECK_TRUE(map.latest_seconds() == first_tai + 100);
    check_tai(100 * second, 0);
    check_tai(130 * second, 1);
    LONGS_EQUAL(101, map.counts().used);
    LONGS_EQUAL(0, map.counts().missed);
    LONGS_EQUAL(0, map.counts().refused);
  }
}

TEST(TimeMap, ADriftThatChangesIsFollowed) {
  pulses(0, 40);
  // From here on the clock is 1 ppm slower; what it shows goes on without a jump.
  const std::int64_t at = pulse(40).ns;
  for (std::int64_t n = 1; n <= 40; ++n) CHECK_TRUE(map.add(Time{at + n * (second + 19'000)}) == Verdict::used);
  LONGS_EQUAL(19'000, map.drift_ppb());
}

TEST(TimeMap, JitterIsSmoothed) {
  Generator g(5);
  std::int64_t worst_offset = 0;
  std::int64_t worst_drift = 0;
  for (std::int64_t n = 0; n < 400; ++n) {
    const std::int64_t jitter = static_cast<std::int64_t>(g.below(20'001)) - 10'000;  // +- 10 us
    CHECK_TRUE(map.add(Time{pulse(n).ns + jitter}) == Verdict::used);
    if (n < 20) continue;
    worst_offset = std::max(worst_offset, std::abs(map.latest_pulse().ns - pulse(n).ns));
    worst_drift = std::max<std::int64_t>(worst_drift, std::abs(map.drift_ppb() - drift_ppb));
  }
  // One sigma is 5.8 us; of the end of a line through 16 pulses half of it, of its slope 5.8 us / sqrt(340) = 313 ns/s.
  CHECK_TRUE(worst_offset < 12'000);
  CHECK_TRUE(worst_offset > 1'000);  // there is jitter
  CHECK_TRUE(worst_drift < 1'500);
  LONGS_EQUAL(0, map.counts().refused);
}

TEST(TimeMap, MissingPulsesAreBridgedAndCounted) {
  pulses(0, 20);
  pulses(24, 24);  // 21 to 23 are missing
  LONGS_EQUAL(3, map.counts().missed);
  CHECK_TRUE(map.latest_seconds() == first_tai + 24);
  pulses(300, 300);
  LONGS_EQUAL(3 + 275, map.counts().missed);
  CHECK_TRUE(map.latest_seconds() == first_tai + 300);
  LONGS_EQUAL(drift_ppb, map.drift_ppb());  // kept, though the window has begun anew
  CHECK_TRUE(map.status(pulse(300)) == SyncStatus::coarse);
  check_tai(301 * second, 1);
  pulses(301, 303);
  CHECK_TRUE(map.status(pulse(303)) == SyncStatus::locked);
}

TEST(TimeMap, SpuriousPulsesAreRefused) {
  pulses(0, 9);
  for (std::int64_t n = 10; n < 40; ++n) {
    CHECK_TRUE(map.add(clock_at(n * second - 700'000'000)) == Verdict::refused);  // regular ones, too
    CHECK_TRUE(map.add(clock_at(n * second - 2'000'000)) == Verdict::refused);
    pulses(n, n);
    CHECK_TRUE(map.add(Time{pulse(n).ns + 50'000}) == Verdict::refused);  // a bounce
    LONGS_EQUAL(drift_ppb, map.drift_ppb());
  }
  LONGS_EQUAL(90, map.counts().refused);
  LONGS_EQUAL(0, map.counts().missed);
  CHECK_TRUE(map.latest_seconds() == first_tai + 39);
}

TEST(TimeMap, TheToleranceIsTheConfiguredOne) {
  drift_ppb = 0;
  pulses(0, 10);
  // 2 ppm of change in one second are 2 us more.
  CHECK_TRUE(map.add(Time{pulse(11).ns + 1'002'001}) == Verdict::refused);
  CHECK_TRUE(map.add(Time{pulse(11).ns + 1'002'000}) == Verdict::used);
  LONGS_EQUAL(1'002'000, map.residual().ns);
  map.configure(config);
  pulses(0, 10);
  CHECK_TRUE(map.add(Time{pulse(11).ns - 1'002'001}) == Verdict::refused);
  CHECK_TRUE(map.add(Time{pulse(11).ns - 1'002'000}) == Verdict::used);
}

TEST(TimeMap, PulsesThatMoveForGoodAreFollowedAnew) {
  pulses(0, 20);
  const std::int64_t step = 300'000'000;
  CHECK_TRUE(map.add(clock_at(21 * second + step)) == Verdict::refused);
  CHECK_TRUE(map.add(clock_at(22 * second + step)) == Verdict::refused);
  CHECK_TRUE(map.add(clock_at(23 * second + step)) == Verdict::restarted);
  LONGS_EQUAL(step, map.step().ns);
  LONGS_EQUAL(2, map.counts().refused);
  CHECK_TRUE(map.latest_seconds() == first_tai + 23);
  CHECK_TRUE(map.status(clock_at(23 * second + step)) == SyncStatus::coarse);
  for (std::int64_t n = 24; n < 30; ++n) CHECK_TRUE(map.add(clock_at(n * second + step)) == Verdict::used);
  CHECK_TRUE(map.status(clock_at(29 * second + step)) == SyncStatus::locked);
  LONGS_EQUAL(drift_ppb, map.drift_ppb());
}

TEST(TimeMap, PulsesThatMovedAreFoundAmongBounces) {
  pulses(0, 20);
  const std::int64_t step = 300'000'000;
  for (std::int64_t n = 21; n < 23; ++n) {
    CHECK_TRUE(map.add(clock_at(n * second + step)) == Verdict::refused);
    CHECK_TRUE(map.add(clock_at(n * second + step + 50'000)) == Verdict::refused);
  }
  CHECK_TRUE(map.add(clock_at(23 * second + step)) == Verdict::restarted);
}

TEST(TimeMap, AFirstEdgeThatWasSpuriousIsCorrected) {
  CHECK_TRUE(map.add(Time{start - 350'000'000}) == Verdict::used);
  CHECK_TRUE(map.add(pulse(0)) == Verdict::refused);
  CHECK_TRUE(map.add(pulse(1)) == Verdict::refused);
  CHECK_TRUE(map.add(pulse(2)) == Verdict::restarted);
  CHECK_TRUE(map.latest_seconds() == first_tai + 2);
}

TEST(TimeMap, StraysThatAreNoSequenceStartNothing) {
  pulses(0, 9);
  Time last = pulse(9);
  Generator g(3);
  for (int i = 0; i < 200; ++i) {  // anything but a second apart
    last = Time{last.ns + 120'000'000 + g.below(300'000'000)};
    const Verdict verdict = map.add(last);
    CHECK_TRUE(verdict != Verdict::restarted);
  }
}

TEST(TimeMap, HoldoverGoesOnWithTheLastDrift) {
  pulses(0, 30);
  CHECK_TRUE(map.status(clock_at(32 * second)) == SyncStatus::locked);
  CHECK_TRUE(map.status(clock_at(33 * second)) == SyncStatus::holdover);
  check_tai(3600 * second, 1);
  pulses(3600, 3600);
  CHECK_TRUE(map.latest_seconds() == first_tai + 3600);
  CHECK_TRUE(map.seconds_source() == SecondsSource::configuration);
}

TEST(TimeMap, AfterTooLongWithoutPulsesTheSecondIsNotGuessed) {
  pulses(0, 30);
  map.name_latest(1000);
  // 249 ms / 2 ppm: so long the whole second is certain.
  const std::int64_t certain_s = 124'500;
  CHECK_TRUE(map.to_tai(Time{map.latest_pulse().ns + certain_s * second}).has_value());
  const Time beyond{map.latest_pulse().ns + (certain_s + 1) * second};
  CHECK_TRUE(map.to_tai(beyond).status() == Status::outside_domain);
  CHECK_TRUE(map.to_clock(Time{(1000 + certain_s + 1) * second}).status() == Status::outside_domain);
  for (int i = 0; i < 2; ++i) CHECK_TRUE(map.add(pulse(124'600 + i)) == Verdict::refused);
  CHECK_TRUE(map.add(pulse(124'602)) == Verdict::restarted);
  CHECK_TRUE(map.seconds_source() == SecondsSource::configuration);
}

TEST(TimeMap, ACommandNamesTheSecond) {
  pulses(0, 5);
  map.name_latest(3'000'000'000);
  CHECK_TRUE(map.seconds_source() == SecondsSource::command);
  CHECK_TRUE(map.latest_seconds() == 3'000'000'000);
  pulses(6, 8);
  CHECK_TRUE(map.latest_seconds() == 3'000'000'003);
  CHECK_TRUE(map.to_tai(pulse(8)).value().ns == 3'000'000'003 * second);
  // It outlives a step of the pulses.
  for (std::int64_t n = 9; n < 12; ++n) static_cast<void>(map.add(clock_at(n * second + 200'000'000)));
  CHECK_TRUE(map.seconds_source() == SecondsSource::command);
  CHECK_TRUE(map.latest_seconds() == 3'000'000'006);
}

TEST(TimeMap, TimesAtTheEndsDoNoHarm) {
  constexpr std::int64_t most = std::numeric_limits<std::int64_t>::max();
  CHECK_TRUE(map.add(Time{-1}) == Verdict::refused);
  CHECK_TRUE(map.add(Time{most}) == Verdict::refused);
  CHECK_TRUE(map.add(Time{std::numeric_limits<std::int64_t>::min()}) == Verdict::refused);
  CHECK_TRUE(map.add(Time{most / 2}) == Verdict::used);
  CHECK_TRUE(map.add(Time{0}) == Verdict::refused);
  CHECK_TRUE(map.to_tai(Time{-1}).status() == Status::outside_domain);
  CHECK_TRUE(map.to_tai(Time{0}).status() == Status::outside_domain);
  CHECK_TRUE(map.to_tai(Time{most}).status() == Status::outside_domain);
  CHECK_TRUE(map.to_clock(Time{most}).status() == Status::outside_domain);
  CHECK_TRUE(map.to_clock(Time{-1}).status() == Status::outside_domain);
  config.tai_offset = {0};
  map.configure(config);
  pulses(0, 1);
  CHECK_TRUE(map.latest_seconds() == 8);  // 7.3 s and a second
}

TEST(TimeMap, ConfigurationsHaveDomains) {
  CHECK_TRUE(TimeMap::is_valid(TimeMapConfig()));
  const auto refused = [](auto spoil) {
    TimeMapConfig c;
    spoil(c);
    return !TimeMap::is_valid(c);
  };
  CHECK_TRUE(refused([](TimeMapConfig& c) { c.tai_offset.ns = -1; }));
  CHECK_TRUE(refused([](TimeMapConfig& c) { c.tai_offset.ns = 4'294'967'295'000'000'001; }));
  CHECK_TRUE(refused([](TimeMapConfig& c) { c.tolerance.ns = 0; }));
  CHECK_TRUE(refused([](TimeMapConfig& c) { c.tolerance.ns = 100'000'001; }));
  CHECK_TRUE(refused([](TimeMapConfig& c) { c.max_drift_ppb = 500'001; }));
  CHECK_TRUE(refused([](TimeMapConfig& c) { c.drift_change_ppb = 0; }));
  CHECK_TRUE(refused([](TimeMapConfig& c) { c.drift_change_ppb = c.max_drift_ppb + 1; }));
  CHECK_TRUE(refused([](TimeMapConfig& c) { c.lock_pulses = 1; }));
  CHECK_TRUE(refused([](TimeMapConfig& c) { c.lock_pulses = 17; }));
  CHECK_TRUE(refused([](TimeMapConfig& c) { c.restart_pulses = 1; }));
  CHECK_TRUE(refused([](TimeMapConfig& c) { c.holdover_after.ns = 999'999'999; }));
}
