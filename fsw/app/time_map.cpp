#include "fsw/app/time_map.hpp"

#include <algorithm>
#include <limits>

#include "fsw/app/saturating.hpp"

namespace relnav::app {
namespace {

/// Times by the clock are from 0 to this (some 146 years), TAI offsets below what 32 bits of seconds count: no sum of them overflows.
constexpr std::int64_t most_ns = std::numeric_limits<std::int64_t>::max() / 2;
constexpr std::int64_t most_offset_ns = 4'294'967'295'000'000'000;

/// a / b rounded down, b > 0.
constexpr std::int64_t floor_div(std::int64_t a, std::int64_t b) { return a / b - (a % b < 0 ? 1 : 0); }
/// a / b to the nearest, halves up, b > 0.
constexpr std::int64_t nearest_div(std::int64_t a, std::int64_t b) { return floor_div(a + b / 2, b); }

/// a * numerator / denominator rounded down, for factors about 10^9, without overflow in between.
constexpr std::int64_t scaled(std::int64_t a, std::int64_t numerator, std::int64_t denominator) {
  const std::int64_t whole = floor_div(a, denominator);
  const std::int64_t rest = a - whole * denominator;
  return whole * numerator + rest * numerator / denominator;
}

constexpr bool is_usable(Time clock) { return clock.ns >= 0 && clock.ns <= most_ns; }
constexpr bool is_near(std::int64_t a, std::int64_t limit) { return a >= -limit && a <= limit; }

}  // namespace

bool TimeMap::is_valid(const TimeMapConfig& c) {
  return c.tai_offset.ns >= 0 && c.tai_offset.ns <= most_offset_ns && c.tolerance.ns > 0 &&
         c.tolerance.ns <= 100'000'000 && c.max_drift_ppb <= 500'000 && c.drift_change_ppb >= 1 &&
         c.drift_change_ppb <= c.max_drift_ppb && c.lock_pulses >= 2 && c.lock_pulses <= window &&
         c.restart_pulses >= 2 && c.holdover_after.ns >= second_ns;
}

void TimeMap::configure(const TimeMapConfig& config) {
  *this = TimeMap();
  config_ = config;
}

TimeMap::Verdict TimeMap::add(Time edge) {
  if (!is_usable(edge)) {
    increment(counts_.refused);
    return Verdict::refused;
  }
  if (!has_pulse()) {
    start(edge);
    return Verdict::used;
  }
  const Expectation expected = expect(edge);
  if (expected.seconds >= 1 && is_near(expected.error_ns, expected.allowance_ns) &&
      expected.allowance_ns <= certain_ns) {
    use(edge, expected);
    return Verdict::used;
  }
  if (!is_new_sequence(edge, expected.error_ns)) {
    increment(counts_.refused);
    return Verdict::refused;
  }
  step_ = {stray_error_ns_};
  // The second is the nearest by the map as it was, unless that cannot be trusted any more.
  const Expected<Time> tai = to_tai(edge);
  const auto source = seconds_source_;
  start(edge);
  if (tai) {
    seconds_ = nearest_div(tai.value().ns, second_ns);
    seconds_source_ = source;
  }
  return Verdict::restarted;
}

std::int64_t TimeMap::allowance_ns(std::int64_t seconds) const {
  return config_.tolerance.ns + seconds * (drift_known_ ? config_.drift_change_ppb : config_.max_drift_ppb);
}

bool TimeMap::is_known_at(std::int64_t since_ns) const {
  return allowance_ns((since_ns < 0 ? -since_ns : since_ns) / second_ns) <= certain_ns;
}

TimeMap::Expectation TimeMap::expect(Time edge) const {
  const std::int64_t since_ns = edge.ns - latest_pulse().ns;
  const std::int64_t length_ns = second_ns + drift_ppb_;
  Expectation expected;
  expected.seconds = nearest_div(since_ns, length_ns);
  expected.error_ns = since_ns - expected.seconds * length_ns;
  expected.allowance_ns = allowance_ns(expected.seconds);
  return expected;
}

void TimeMap::start(Time edge) {
  pulses_[0] = {edge, 0};
  newest_ = 0;
  size_ = 1;
  latest_ = edge;
  n_ = 0;
  correction_ns_ = 0;
  drift_ppb_ = 0;
  drift_known_ = false;
  seconds_ = nearest_div(edge.ns + config_.tai_offset.ns, second_ns);
  seconds_source_ = telemetry::SecondsSource::configuration;
  residual_ = {};
  strays_ = 0;
  increment(counts_.used);
}

void TimeMap::use(Time edge, const Expectation& expected) {
  const auto missed = static_cast<std::uint32_t>(std::min<std::int64_t>(expected.seconds - 1, 0xFFFFFFFF));
  counts_.missed = saturated_sum(counts_.missed, missed);
  increment(counts_.used);
  residual_ = {expected.error_ns};
  strays_ = 0;
  latest_ = edge;
  n_ += expected.seconds;
  seconds_ += expected.seconds;
  newest_ = (newest_ + 1) % window;
  pulses_[newest_] = {edge, n_};
  if (size_ < window) ++size_;
  fit();
}

void TimeMap::fit() {
  // Pulses that are too old go, so that n and y stay small: |n| <= 64, |y| <= 64 (0.5 ms + ...) + 100 ms, and no sum overflows.
  for (std::size_t i = 0; i < window; ++i) {
    if (size_ > 1 && n_ - pulses_[(newest_ + window + 1 - size_) % window].n > window_seconds) --size_;
  }
  std::int64_t sum_n = 0;
  std::int64_t sum_y = 0;
  std::int64_t sum_nn = 0;
  std::int64_t sum_ny = 0;
  for (std::size_t i = 0; i < size_; ++i) {
    const Pulse& pulse = pulses_[(newest_ + window - i) % window];
    const std::int64_t n = pulse.n - n_;
    const std::int64_t y = pulse.edge.ns - latest_.ns - n * second_ns;
    sum_n += n;
    sum_y += y;
    sum_nn += n * n;
    sum_ny += n * y;
  }
  const auto count = static_cast<std::int64_t>(size_);
  if (count >= config_.lock_pulses) {
    const std::int64_t determinant = count * sum_nn - sum_n * sum_n;  // > 0: no two n are equal
    const std::int64_t slope = nearest_div(count * sum_ny - sum_n * sum_y, determinant);
    drift_ppb_ =
        static_cast<std::int32_t>(std::clamp<std::int64_t>(slope, -config_.max_drift_ppb, config_.max_drift_ppb));
    drift_known_ = true;
  }
  // Without a line of this window's own the drift known before goes through its middle.
  correction_ns_ = nearest_div(sum_y - drift_ppb_ * sum_n, count);
}

bool TimeMap::is_new_sequence(Time edge, std::int64_t error_ns) {
  const std::int64_t since_ns = edge.ns - stray_.ns;
  const std::int64_t allowance = config_.tolerance.ns + config_.max_drift_ppb;
  if (strays_ > 0 && is_near(since_ns - second_ns, allowance)) {
    increment(strays_);
  } else if (strays_ > 0 && since_ns >= 0 && since_ns < second_ns / 2) {
    return false;  // between two of a sequence
  } else {
    strays_ = 1;
    stray_error_ns_ = error_ns;
  }
  stray_ = edge;
  return strays_ >= config_.restart_pulses;
}

void TimeMap::name_latest(std::uint32_t tai_seconds) {
  seconds_ = tai_seconds;
  seconds_source_ = telemetry::SecondsSource::command;
}

telemetry::SyncStatus TimeMap::status(Time now) const {
  if (!has_pulse()) return telemetry::SyncStatus::none;
  if (now - latest_ > config_.holdover_after) return telemetry::SyncStatus::holdover;
  return size_ < config_.lock_pulses ? telemetry::SyncStatus::coarse : telemetry::SyncStatus::locked;
}

Expected<Time> TimeMap::to_tai(Time clock) const {
  if (!has_pulse()) return Status::no_data;
  if (!is_usable(clock)) return Status::outside_domain;
  const std::int64_t since_ns = clock.ns - latest_pulse().ns;
  if (!is_known_at(since_ns)) return Status::outside_domain;
  return Time{seconds_ * second_ns + scaled(since_ns, second_ns, second_ns + drift_ppb_)};
}

Expected<Time> TimeMap::to_clock(Time tai) const {
  if (!has_pulse()) return Status::no_data;
  if (tai.ns < 0) return Status::outside_domain;
  const std::int64_t since_ns = tai.ns - seconds_ * second_ns;
  if (!is_known_at(since_ns)) return Status::outside_domain;
  return Time{latest_pulse().ns + scaled(since_ns, second_ns + drift_ppb_, second_ns)};
}

}  // namespace relnav::app
