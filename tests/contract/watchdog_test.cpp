#include "platform/host/scripted_clock.hpp"
#include "platform/host/scripted_watchdog.hpp"
#include "tests/contract/watchdog_contract.hpp"

namespace {

using relnav::Duration;
using relnav::Status;

struct ScriptedWatchdogHarness {
  relnav::platform::host::ScriptedClock clock;
  relnav::platform::host::ScriptedWatchdog scripted;
  ScriptedWatchdogHarness() { scripted.attach_clock(clock, deadline()); }
  relnav::hal::Watchdog& watchdog() { return scripted; }
  bool reacted() { return scripted.reacted(); }
  Duration deadline() const { return {1000}; }
  void pass(Duration length) { clock.advance(length); }
};

}  // namespace

RELNAV_WATCHDOG_CONTRACT(ScriptedWatchdogContract, ScriptedWatchdogHarness)

TEST_GROUP(ScriptedWatchdog) { ScriptedWatchdogHarness harness; };

TEST(ScriptedWatchdog, RefusedKicksCountButDoNotRestartTheDeadline) {
  harness.scripted.fail_kicks(Status::io_error, 2);
  harness.pass({900});
  CHECK_TRUE(harness.watchdog().kick() == Status::io_error);
  harness.pass({200});
  CHECK_TRUE(harness.reacted());
  LONGS_EQUAL(1, harness.scripted.kicks());
  LONGS_EQUAL(0, harness.scripted.trips());
}

TEST(ScriptedWatchdog, NeedsNoClock) {
  relnav::platform::host::ScriptedWatchdog alone;
  for (int i = 0; i < 10; ++i) CHECK_TRUE(alone.kick() == Status::ok);
  CHECK_FALSE(alone.reacted());
  LONGS_EQUAL(10, alone.kicks());
}
