#pragma once
/// Contract of hal::Watchdog. A harness has:
///   hal::Watchdog& watchdog();         just started
///   bool reacted();                    the safe reaction was asked for
///   Duration deadline();
///   void pass(Duration);               lets time pass
#include "fsw/base/time.hpp"
#include "hal/watchdog.hpp"
#include "tests/contract/clause.hpp"

namespace relnav::watchdog_contract {

template <typename Harness>
void WDG_1_kicks_in_time_prevent_the_reaction(Harness& harness) {
  for (int i = 0; i < 5; ++i) {
    harness.pass(Duration{harness.deadline().ns * 3 / 4});
    CHECK_FALSE(harness.reacted());
    CHECK_TRUE(harness.watchdog().kick() == Status::ok);
  }
  CHECK_FALSE(harness.reacted());
}

template <typename Harness>
void WDG_2_trip_reacts_at_once_and_kicks_are_refused(Harness& harness) {
  CHECK_TRUE(harness.watchdog().kick() == Status::ok);
  CHECK_TRUE(harness.watchdog().trip() == Status::ok);
  CHECK_TRUE(harness.reacted());
  for (int i = 0; i < 3; ++i) CHECK_TRUE(harness.watchdog().kick() == Status::device_lost);
  CHECK_TRUE(harness.reacted());
}

template <typename Harness>
void WDG_3_a_missed_deadline_reacts(Harness& harness) {
  CHECK_TRUE(harness.watchdog().kick() == Status::ok);
  harness.pass(Duration{harness.deadline().ns * 5 / 4});
  CHECK_TRUE(harness.reacted());
  CHECK_TRUE(harness.watchdog().kick() == Status::device_lost);
}

template <typename Harness>
void WDG_4_trip_may_be_repeated(Harness& harness) {
  CHECK_TRUE(harness.watchdog().trip() == Status::ok);
  CHECK_TRUE(harness.watchdog().trip() == Status::ok);
  CHECK_TRUE(harness.reacted());
}

}  // namespace relnav::watchdog_contract

#define RELNAV_WATCHDOG_CONTRACT(group, Harness)                                                   \
  TEST_GROUP(group) { Harness harness; };                                                          \
  RELNAV_CLAUSE(group, relnav::watchdog_contract, WDG_1_kicks_in_time_prevent_the_reaction)        \
  RELNAV_CLAUSE(group, relnav::watchdog_contract, WDG_2_trip_reacts_at_once_and_kicks_are_refused) \
  RELNAV_CLAUSE(group, relnav::watchdog_contract, WDG_3_a_missed_deadline_reacts)                  \
  RELNAV_CLAUSE(group, relnav::watchdog_contract, WDG_4_trip_may_be_repeated)
