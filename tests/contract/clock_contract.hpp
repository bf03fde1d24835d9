#pragma once
/// Contract of hal::Clock. A harness has:
///   hal::Clock& clock();
///   void pass_time();   lets at least a microsecond pass
#include "hal/clock.hpp"
#include "tests/contract/clause.hpp"

namespace relnav::clock_contract {

template <typename Harness>
void CLK_1_never_goes_back(Harness& harness) {
  Time last = harness.clock().now();
  for (int i = 0; i < 10000; ++i) {
    const Time time = harness.clock().now();
    CHECK_TRUE(time >= last);
    last = time;
  }
  harness.pass_time();
  CHECK_TRUE((harness.clock().now() - last).ns >= 1000);
}

template <typename Harness>
void CLK_2_names_its_time_scale(Harness& harness) {
  const hal::ClockId id = harness.clock().id();
  harness.pass_time();
  static_cast<void>(harness.clock().now());
  CHECK_TRUE(harness.clock().id() == id);
}

}  // namespace relnav::clock_contract

#define RELNAV_CLOCK_CONTRACT(group, Harness)                         \
  TEST_GROUP(group) { Harness harness; };                             \
  RELNAV_CLAUSE(group, relnav::clock_contract, CLK_1_never_goes_back) \
  RELNAV_CLAUSE(group, relnav::clock_contract, CLK_2_names_its_time_scale)
