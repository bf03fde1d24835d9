// In the guest: hal::GpioLines on the kernel's own GPIO interface. make_lines has made eight lines, STROBE and PPS the first.
#include <CppUTest/TestHarness.h>

#include <memory>

#include "platform/linux/gpiod_lines.hpp"
#include "platform/linux/monotonic_clock.hpp"
#include "tests/contract/gpio_lines_contract.hpp"
#include "tests/hil/vm/guest_resources.hpp"
#include "tests/hil/vm/simulated_lines.hpp"

namespace {

using relnav::Duration;
using relnav::Status;
using relnav::Time;
using relnav::hal::Edges;
using relnav::hal::LineEdge;
using relnav::platform::linux::GpiodLines;
using relnav::platform::linux::make_gpiod_backend;
using relnav::test::SimulatedLines;

class Harness {
 public:
  Harness() {
    for (std::uint32_t offset = 0; offset < no_line(); ++offset) CHECK_TRUE(outside_.drive(offset, false));
    CHECK_TRUE(lines_.open(SimulatedLines::label) == Status::ok);
  }
  GpiodLines& lines() { return lines_; }
  std::uint32_t line_a() const { return 2; }
  std::uint32_t line_b() const { return 5; }
  std::uint32_t no_line() const { return 8; }
  bool level(std::uint32_t offset) const { return outside_.level(offset); }
  bool drive(std::uint32_t offset, bool level) const { return outside_.drive(offset, level); }
  std::size_t unread_edges() const { return backend_->kept_edges(); }
  bool lose_device() { return outside_.set_alive(false); }
  void restore_device() { CHECK_TRUE(outside_.set_alive(true)); }
  Duration wait() const { return {1'000'000'000}; }
  Time now() { return clock_.now(); }
  Duration slack() const { return {500'000'000}; }  // emulated

 private:
  SimulatedLines outside_;
  relnav::platform::linux::MonotonicClock clock_;
  std::unique_ptr<relnav::platform::linux::GpioBackend> backend_ = make_gpiod_backend();
  GpiodLines lines_{*backend_};
};

}  // namespace

TEST_GROUP(GuestLines) { Harness harness; };
RELNAV_CLAUSE(GuestLines, relnav::gpio_lines_contract, GPIO_1_lines_not_requested_are_not_configured)
RELNAV_CLAUSE(GuestLines, relnav::gpio_lines_contract, GPIO_2_bad_requests_are_refused)
RELNAV_CLAUSE(GuestLines, relnav::gpio_lines_contract, GPIO_3_output_starts_at_its_initial_level)
RELNAV_CLAUSE(GuestLines, relnav::gpio_lines_contract, GPIO_4_set_takes_effect_on_its_own_line)
RELNAV_CLAUSE(GuestLines, relnav::gpio_lines_contract, GPIO_4_set_of_an_input_is_refused)
RELNAV_CLAUSE(GuestLines, relnav::gpio_lines_contract, GPIO_5_get_reads_the_line)
RELNAV_CLAUSE(GuestLines, relnav::gpio_lines_contract, GPIO_6_edges_come_once_in_order_and_as_asked)
RELNAV_CLAUSE(GuestLines, relnav::gpio_lines_contract, GPIO_6_both_and_none)
RELNAV_CLAUSE(GuestLines, relnav::gpio_lines_contract, GPIO_7_never_waits_longer_than_asked)
RELNAV_CLAUSE(GuestLines, relnav::gpio_lines_contract, GPIO_9_released_lines_start_anew)
RELNAV_CLAUSE(GuestLines, relnav::gpio_lines_contract, GPIO_10_device_lost)

// GPIO-8 as far as version 1 of libgpiod allows: it does not count edges, so a full kernel buffer is one gap of at least one.
TEST(GuestLines, LostEdgesShowAsAGap) {
  CHECK_TRUE(harness.lines().request_input(harness.line_a(), Edges::both) == Status::ok);
  const std::size_t kept = harness.unread_edges();
  for (std::size_t i = 0; i < kept + 4; ++i) CHECK_TRUE(harness.drive(harness.line_a(), i % 2 == 0));
  std::size_t read = 0;
  std::uint32_t last = 0;
  LineEdge edge;
  while (harness.lines().wait_edge(Duration{0}, edge) == Status::ok) {
    ++read;
    LONGS_EQUAL(read, edge.sequence);
    last = edge.sequence;
  }
  LONGS_EQUAL(kept, read);
  CHECK_TRUE(harness.drive(harness.line_a(), kept % 2 == 0));
  CHECK_TRUE(harness.lines().wait_edge(harness.wait(), edge) == Status::ok);
  CHECK_TRUE(edge.sequence > last + 1);
}

TEST(GuestLines, EdgesBearTheMonotonicTimeOfTheirInjection) {
  std::uint32_t pps = 99;
  CHECK_TRUE(harness.lines().find_line("PPS", pps) == Status::ok);
  LONGS_EQUAL(1, pps);
  CHECK_TRUE(harness.lines().request_input(pps, Edges::rising) == Status::ok);
  for (int i = 0; i < 20; ++i) {
    const Time before = harness.now();
    CHECK_TRUE(harness.drive(pps, true));
    const Time after = harness.now();
    CHECK_TRUE(harness.drive(pps, false));
    LineEdge edge;
    CHECK_TRUE(harness.lines().wait_edge(harness.wait(), edge) == Status::ok);
    CHECK_TRUE(edge.clock == relnav::hal::ClockId::monotonic);
    CHECK_TRUE(edge.time >= before);
    // The interrupt is played by a work item, which may run after the write has returned.
    CHECK_TRUE(edge.time <= after + harness.slack());
  }
}

TEST(GuestLines, AStrobeIsSeenOutside) {
  std::uint32_t strobe = 99;
  CHECK_TRUE(harness.lines().find_line("STROBE", strobe) == Status::ok);
  LONGS_EQUAL(0, strobe);
  CHECK_TRUE(harness.lines().request_output(strobe, false) == Status::ok);
  for (int i = 0; i < 100; ++i) {
    CHECK_TRUE(harness.lines().set(strobe, i % 2 == 0) == Status::ok);
    CHECK_TRUE(harness.level(strobe) == (i % 2 == 0));
  }
}

TEST(GuestLines, ALineOfAnotherProcessIsRefused) {
  const auto other_backend = make_gpiod_backend();
  GpiodLines other(*other_backend);
  CHECK_TRUE(other.open(SimulatedLines::label) == Status::ok);
  CHECK_TRUE(other.request_output(3, true) == Status::ok);
  CHECK_TRUE(harness.lines().request_output(3, false) == Status::no_capacity);
  CHECK_TRUE(harness.lines().problem().find("STROBE") == std::string::npos);
  CHECK_TRUE(harness.lines().problem().find("3") != std::string::npos);
  CHECK_TRUE(harness.level(3));
}

// Not more often: Linux 6.1 itself never gives back the numbers of a chip that vanished with lines requested, and has 512.
TEST(GuestLines, FiftyLossesLeakNothing) {
  const int before = relnav::test::resources().files;
  for (int i = 0; i < 50; ++i) {
    CHECK_TRUE(harness.lines().request_output(0, true) == Status::ok);
    CHECK_TRUE(harness.lines().request_input(1, Edges::both) == Status::ok);
    CHECK_TRUE(harness.lose_device());
    CHECK_TRUE(harness.lines().set(0, false) == Status::device_lost);
    CHECK_TRUE(harness.lines().release(0) == Status::ok);
    CHECK_TRUE(harness.lines().release(1) == Status::ok);
    harness.restore_device();
    CHECK_TRUE(harness.lines().request_output(0, true) == Status::ok);
    CHECK_TRUE(harness.level(0));
    CHECK_TRUE(harness.lines().release(0) == Status::ok);
  }
  LONGS_EQUAL(before, relnav::test::resources().files);
}
