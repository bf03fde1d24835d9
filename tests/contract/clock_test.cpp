#include <chrono>
#include <thread>

#include "platform/host/scripted_clock.hpp"
#include "platform/host/steady_clock.hpp"
#include "tests/contract/clock_contract.hpp"

namespace {

using relnav::Time;

struct ScriptedClockHarness {
  relnav::platform::host::ScriptedClock scripted{Time{5}, relnav::hal::ClockId::tai};
  relnav::hal::Clock& clock() { return scripted; }
  void pass_time() { scripted.advance({1000}); }
};

struct SteadyClockHarness {
  relnav::platform::host::SteadyClock steady;
  relnav::hal::Clock& clock() { return steady; }
  void pass_time() { std::this_thread::sleep_for(std::chrono::microseconds(2)); }
};

}  // namespace

RELNAV_CLOCK_CONTRACT(ScriptedClockContract, ScriptedClockHarness)
RELNAV_CLOCK_CONTRACT(SteadyClockContract, SteadyClockHarness)

TEST_GROUP(ScriptedClock) { relnav::platform::host::ScriptedClock clock{Time{100}}; };

TEST(ScriptedClock, MovesOnlyWhenTold) {
  CHECK_TRUE(clock.now() == Time{100});
  CHECK_TRUE(clock.now() == Time{100});
  clock.advance({5});
  clock.advance({-50});
  CHECK_TRUE(clock.now() == Time{105});
  clock.set_tick({2});
  CHECK_TRUE(clock.now() == Time{105});
  CHECK_TRUE(clock.now() == Time{107});
  clock.jump_to(Time{1});
  CHECK_TRUE(clock.peek() == Time{1});
  LONGS_EQUAL(5, clock.calls());
}
