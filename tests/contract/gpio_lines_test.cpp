#include <cstdint>

#include "platform/host/scripted_clock.hpp"
#include "platform/host/scripted_gpio_lines.hpp"
#include "tests/contract/gpio_lines_contract.hpp"

namespace {

using relnav::Duration;
using relnav::Status;
using relnav::Time;
using relnav::platform::host::GpioCall;
using relnav::platform::host::ScriptedClock;
using relnav::platform::host::ScriptedGpioLines;

class ScriptedGpioHarness {
 public:
  ScriptedGpioHarness() { lines_.attach_clock(clock_); }
  relnav::hal::GpioLines& lines() { return lines_; }
  ScriptedGpioLines& script() { return lines_; }
  std::uint32_t line_a() const { return 3; }
  std::uint32_t line_b() const { return 7; }
  std::uint32_t no_line() const { return 8; }
  bool level(std::uint32_t offset) const { return lines_.level(offset); }
  bool drive(std::uint32_t offset, bool level) {
    clock_.advance({10});
    return lines_.drive(offset, level, clock_.peek()) == Status::ok;
  }
  std::size_t unread_edges() const { return 16; }
  bool lose_device() {
    lines_.lose_device();
    return true;
  }
  void restore_device() { lines_.restore_device(); }
  Duration wait() const { return {1000}; }
  Time now() const { return clock_.peek(); }
  Duration slack() const { return {0}; }

 private:
  ScriptedClock clock_;
  ScriptedGpioLines lines_{8, 16};
};

}  // namespace

RELNAV_GPIO_LINES_CONTRACT(ScriptedGpioLinesContract, ScriptedGpioHarness)

TEST_GROUP(ScriptedGpioLines) { ScriptedGpioHarness harness; };

TEST(ScriptedGpioLines, PlaysFaultsAndRecordsCalls) {
  CHECK_TRUE(harness.lines().request_output(1, false) == Status::ok);
  harness.script().fail_calls(Status::io_error, 2);
  CHECK_TRUE(harness.lines().set(1, true) == Status::io_error);
  bool level = true;
  CHECK_TRUE(harness.lines().get(1, level) == Status::io_error);
  CHECK_TRUE(level);
  CHECK_FALSE(harness.level(1));
  CHECK_TRUE(harness.lines().set(1, true) == Status::ok);
  const auto& calls = harness.script().calls();
  LONGS_EQUAL(4, calls.size());
  CHECK_TRUE(calls[1].kind == GpioCall::Kind::set);
  CHECK_TRUE(calls[1].answer == Status::io_error);
  CHECK_TRUE(calls[3].level);
}

TEST(ScriptedGpioLines, EdgesAreSortedByTheirTime) {
  CHECK_TRUE(harness.lines().request_input(0, relnav::hal::Edges::both) == Status::ok);
  CHECK_TRUE(harness.lines().request_input(1, relnav::hal::Edges::both) == Status::ok);
  CHECK_TRUE(harness.script().drive(0, true, Time{200}) == Status::ok);
  CHECK_TRUE(harness.script().drive(1, true, Time{100}) == Status::ok);
  relnav::hal::LineEdge edge;
  CHECK_TRUE(harness.lines().wait_edge({0}, edge) == Status::ok);
  LONGS_EQUAL(1, edge.offset);
}

TEST(ScriptedGpioLines, OutputsCannotBeDrivenFromOutside) {
  CHECK_TRUE(harness.lines().request_output(1, false) == Status::ok);
  CHECK_TRUE(harness.script().drive(1, true, Time{1}) == Status::invalid_argument);
  CHECK_FALSE(harness.level(1));
}
