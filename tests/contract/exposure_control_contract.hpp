#pragma once
/// Contract of hal::ExposureControl. A harness has:
///   hal::ExposureControl& control();   its camera not started
///   Status start();                    starts the camera
///   bool lose_device();                false: cannot be played here
///   void restore_device();             start() succeeds again
///   bool refuse_next();                the device will not take the next set(); false: cannot be played here
///   Duration next_exposure();          Frame::exposure of the next frame, which is exposed now
///   hal::Exposure in_device();         what the device itself is set to
///   Time now();                        on the clock that waiting uses up
///   Duration slack();                  how long an answer of the device may take on it
#include <cmath>
#include <limits>

#include "hal/exposure_control.hpp"
#include "tests/contract/clause.hpp"

namespace relnav::exposure_control_contract {

inline const hal::Exposure untouched{Duration{12'345}, 6.5};

template <typename Harness>
hal::ExposureLimits limits_of(Harness& harness) {
  hal::ExposureLimits limits;
  CHECK_TRUE(harness.control().limits(limits) == Status::ok);
  return limits;
}

/// Somewhere inside: `part` of the way, in proportions.
inline hal::Exposure between(const hal::ExposureLimits& limits, double part) {
  const auto mix = [part](double low, double high) { return low * std::pow(high / low, part); };
  return {Duration{static_cast<std::int64_t>(
              mix(static_cast<double>(limits.time_min.ns), static_cast<double>(limits.time_max.ns)))},
          mix(limits.gain_min, limits.gain_max)};
}

inline bool is_inside(const hal::Exposure& exposure, const hal::ExposureLimits& limits) {
  return exposure.time >= limits.time_min && exposure.time <= limits.time_max && exposure.gain >= limits.gain_min &&
         exposure.gain <= limits.gain_max;
}

template <typename Harness>
void check_refused(Harness& harness, const hal::Exposure& wanted, Status expected) {
  hal::Exposure applied = untouched;
  CHECK_TRUE(harness.control().set(wanted, applied) == expected);
  CHECK_TRUE(applied == untouched);
}

template <typename Harness>
void EXP_1_nothing_without_a_camera(Harness& harness) {
  hal::ExposureLimits limits;
  limits.time_min = Duration{777};
  CHECK_TRUE(harness.control().limits(limits) == Status::not_configured);
  LONGS_EQUAL(777, limits.time_min.ns);
  check_refused(harness, {Duration{1'000'000}, 1.0}, Status::not_configured);
  CHECK_TRUE(harness.start() == Status::ok);
  const hal::Exposure inside = between(limits_of(harness), 0.5);
  if (!harness.lose_device()) return;
  CHECK_TRUE(harness.control().limits(limits) == Status::device_lost);
  LONGS_EQUAL(777, limits.time_min.ns);
  check_refused(harness, inside, Status::device_lost);
}

template <typename Harness>
void EXP_2_limits_are_in_order_and_stay(Harness& harness) {
  CHECK_TRUE(harness.start() == Status::ok);
  const hal::ExposureLimits limits = limits_of(harness);
  CHECK_TRUE(limits.time_min.ns > 0 && limits.time_min <= limits.time_max);
  CHECK_TRUE(limits.gain_min > 0.0 && limits.gain_min <= limits.gain_max && std::isfinite(limits.gain_max));
  hal::Exposure applied;
  CHECK_TRUE(harness.control().set(between(limits, 0.7), applied) == Status::ok);
  const hal::ExposureLimits again = limits_of(harness);
  CHECK_TRUE(again.time_min == limits.time_min && again.time_max == limits.time_max);
  DOUBLES_EQUAL(limits.gain_min, again.gain_min, 0.0);
  DOUBLES_EQUAL(limits.gain_max, again.gain_max, 0.0);
}

template <typename Harness>
void EXP_3_outside_is_refused(Harness& harness) {
  CHECK_TRUE(harness.start() == Status::ok);
  const hal::ExposureLimits limits = limits_of(harness);
  hal::Exposure before;
  CHECK_TRUE(harness.control().set(between(limits, 0.4), before) == Status::ok);
  for (const double gain : {limits.gain_min * 0.99, limits.gain_max * 1.01, 0.0, -1.0,
                            std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    check_refused(harness, {before.time, gain}, Status::invalid_argument);
  }
  for (const std::int64_t time_ns :
       {limits.time_min.ns - 1, limits.time_max.ns + 1, std::int64_t{0}, std::int64_t{-1},
        std::numeric_limits<std::int64_t>::max(), std::numeric_limits<std::int64_t>::min()}) {
    check_refused(harness, {Duration{time_ns}, before.gain}, Status::invalid_argument);
  }
  CHECK_TRUE(harness.in_device() == before);
}

template <typename Harness>
void EXP_4_applied_is_what_the_device_has(Harness& harness) {
  CHECK_TRUE(harness.start() == Status::ok);
  const hal::ExposureLimits limits = limits_of(harness);
  for (const double part : {0.0, 0.13, 0.5, 0.77, 1.0}) {
    hal::Exposure applied;
    CHECK_TRUE(harness.control().set(between(limits, part), applied) == Status::ok);
    CHECK_TRUE(is_inside(applied, limits));
    CHECK_TRUE(harness.in_device() == applied);
    hal::Exposure again;
    CHECK_TRUE(harness.control().set(applied, again) == Status::ok);
    CHECK_TRUE(again == applied);
  }
  hal::Exposure most;
  CHECK_TRUE(harness.control().set({limits.time_max, limits.gain_max}, most) == Status::ok);
  CHECK_TRUE(harness.control().set({limits.time_min, limits.gain_min}, most) == Status::ok);
}

template <typename Harness>
void EXP_5_frames_carry_their_exposure(Harness& harness) {
  CHECK_TRUE(harness.start() == Status::ok);
  const hal::ExposureLimits limits = limits_of(harness);
  hal::Exposure first;
  CHECK_TRUE(harness.control().set(between(limits, 0.3), first) == Status::ok);
  for (int i = 0; i < 2; ++i) static_cast<void>(harness.next_exposure());
  CHECK_TRUE(harness.next_exposure() == first.time);
  hal::Exposure second;
  CHECK_TRUE(harness.control().set(between(limits, 0.6), second) == Status::ok);
  CHECK_FALSE(first.time == second.time);
  for (int i = 0; i < 2; ++i) {
    const Duration seen = harness.next_exposure();
    CHECK_TRUE(seen == first.time || seen == second.time);
  }
  CHECK_TRUE(harness.next_exposure() == second.time);
}

template <typename Harness>
void EXP_6_a_failure_changes_nothing(Harness& harness) {
  CHECK_TRUE(harness.start() == Status::ok);
  const hal::ExposureLimits limits = limits_of(harness);
  hal::Exposure before;
  CHECK_TRUE(harness.control().set(between(limits, 0.4), before) == Status::ok);
  if (!harness.refuse_next()) return;
  hal::Exposure applied = untouched;
  CHECK_TRUE(harness.control().set(between(limits, 0.8), applied) == Status::io_error);
  CHECK_TRUE(applied == untouched);
  CHECK_TRUE(harness.in_device() == before);
  CHECK_TRUE(harness.control().set(between(limits, 0.8), applied) == Status::ok);
  CHECK_TRUE(harness.in_device() == applied);
}

template <typename Harness>
void EXP_7_a_camera_that_comes_back_is_told_again(Harness& harness) {
  CHECK_TRUE(harness.start() == Status::ok);
  hal::Exposure applied;
  CHECK_TRUE(harness.control().set(between(limits_of(harness), 0.6), applied) == Status::ok);
  if (!harness.lose_device()) return;
  harness.restore_device();
  CHECK_TRUE(harness.start() == Status::ok);
  CHECK_TRUE(harness.in_device() == applied);
  CHECK_TRUE(harness.next_exposure() == applied.time);
}

template <typename Harness>
void EXP_8_nobody_waits_for_a_frame(Harness& harness) {
  CHECK_TRUE(harness.start() == Status::ok);
  const Time before = harness.now();
  hal::Exposure applied;
  CHECK_TRUE(harness.control().set(between(limits_of(harness), 0.9), applied) == Status::ok);
  CHECK_TRUE(harness.now() - before <= harness.slack());
}

}  // namespace relnav::exposure_control_contract

#define RELNAV_EXPOSURE_CONTROL_CONTRACT(group, Harness)                                                \
  TEST_GROUP(group) { Harness harness; };                                                               \
  RELNAV_CLAUSE(group, relnav::exposure_control_contract, EXP_1_nothing_without_a_camera)               \
  RELNAV_CLAUSE(group, relnav::exposure_control_contract, EXP_2_limits_are_in_order_and_stay)           \
  RELNAV_CLAUSE(group, relnav::exposure_control_contract, EXP_3_outside_is_refused)                     \
  RELNAV_CLAUSE(group, relnav::exposure_control_contract, EXP_4_applied_is_what_the_device_has)         \
  RELNAV_CLAUSE(group, relnav::exposure_control_contract, EXP_5_frames_carry_their_exposure)            \
  RELNAV_CLAUSE(group, relnav::exposure_control_contract, EXP_6_a_failure_changes_nothing)              \
  RELNAV_CLAUSE(group, relnav::exposure_control_contract, EXP_7_a_camera_that_comes_back_is_told_again) \
  RELNAV_CLAUSE(group, relnav::exposure_control_contract, EXP_8_nobody_waits_for_a_frame)
