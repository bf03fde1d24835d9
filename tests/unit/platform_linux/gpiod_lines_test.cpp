#include "platform/linux/gpiod_lines.hpp"

#include <CppUTest/TestHarness.h>
#include <unistd.h>

#include <chrono>
#include <thread>

#include "platform/linux/gpio_chip.hpp"
#include "platform/linux/monotonic_clock.hpp"
#include "tests/support/fake_gpio_backend.hpp"

namespace {

using relnav::Duration;
using relnav::Status;
using relnav::Time;
using relnav::hal::Edges;
using relnav::hal::LineEdge;
using relnav::platform::linux::GpiodLines;
using relnav::test::FakeGpioBackend;

Time now() { return relnav::platform::linux::MonotonicClock().now(); }
bool contains(const std::string& text, const char* part) { return text.find(part) != std::string::npos; }

}  // namespace

TEST_GROUP(GpiodLines) {
  FakeGpioBackend backend{8};
  GpiodLines lines{backend};
  void setup() override { CHECK_TRUE(lines.open_path("fake") == Status::ok); }
};

TEST(GpiodLines, LinesAreFoundByOffsetOrName) {
  backend.set_name(2, "STROBE");
  backend.set_name(5, "PPS");
  backend.set_name(6, "SPARE");
  backend.set_name(7, "SPARE");
  std::uint32_t offset = 99;
  CHECK_TRUE(lines.find_line("STROBE", offset) == Status::ok);
  LONGS_EQUAL(2, offset);
  CHECK_TRUE(lines.find_line("7", offset) == Status::ok);
  LONGS_EQUAL(7, offset);
  CHECK_TRUE(lines.find_line("8", offset) == Status::invalid_argument);
  CHECK_TRUE(contains(lines.problem(), "no line 8; expected 0 to 7"));
  CHECK_TRUE(lines.find_line("99999999999", offset) == Status::invalid_argument);
  CHECK_TRUE(lines.find_line("strobe", offset) == Status::invalid_argument);
  CHECK_TRUE(contains(lines.problem(), "no line is named \"strobe\""));
  CHECK_TRUE(contains(lines.problem(), "STROBE, PPS, SPARE"));
  CHECK_TRUE(lines.find_line("SPARE", offset) == Status::ambiguous);
  CHECK_TRUE(lines.find_line("", offset) == Status::invalid_argument);
  LONGS_EQUAL(7, offset);
}

TEST(GpiodLines, NothingWorksBeforeOpenAndAfterClose) {
  lines.close();
  bool level = true;
  LineEdge edge;
  std::uint32_t offset = 0;
  CHECK_TRUE(lines.request_output(1, true) == Status::not_configured);
  CHECK_TRUE(lines.set(1, true) == Status::not_configured);
  CHECK_TRUE(lines.get(1, level) == Status::not_configured);
  CHECK_TRUE(lines.wait_edge({0}, edge) == Status::not_configured);
  CHECK_TRUE(lines.find_line("1", offset) == Status::not_configured);
}

TEST(GpiodLines, ALineOfAnotherProcessIsNoCapacity) {
  backend.occupy(1);
  CHECK_TRUE(lines.request_output(1, true) == Status::no_capacity);
  CHECK_TRUE(contains(lines.problem(), "line 1: busy"));
  CHECK_FALSE(backend.level(1));
}

TEST(GpiodLines, AFaultOfOneCallIsPassedOnAndLeavesTheLine) {
  CHECK_TRUE(lines.request_output(1, false) == Status::ok);
  backend.fail_next(Status::io_error);
  CHECK_TRUE(lines.set(1, true) == Status::io_error);
  CHECK_TRUE(lines.set(1, true) == Status::ok);
  CHECK_TRUE(backend.level(1));
}

TEST(GpiodLines, AnEdgeEndsTheWait) {
  CHECK_TRUE(lines.request_input(4, Edges::rising) == Status::ok);
  std::thread world([this] {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    backend.drive(4, true, now());
  });
  const Time before = now();
  LineEdge edge;
  const Status status = lines.wait_edge(Duration{5'000'000'000}, edge);
  const Duration waited = now() - before;
  world.join();
  CHECK_TRUE(status == Status::ok);
  LONGS_EQUAL(4, edge.offset);
  CHECK_TRUE(waited.ns > 10'000'000);
  CHECK_TRUE(waited.ns < 2'000'000'000);
}

TEST(GpiodLines, LossOfTheChipEndsTheWait) {
  CHECK_TRUE(lines.request_input(4, Edges::rising) == Status::ok);
  std::thread world([this] {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    backend.unplug();
  });
  const Time before = now();
  LineEdge edge;
  const Status status = lines.wait_edge(Duration{5'000'000'000}, edge);
  world.join();
  CHECK_TRUE(status == Status::device_lost);
  CHECK_TRUE((now() - before).ns < 2'000'000'000);
  CHECK_FALSE(backend.is_open());
}

TEST(GpiodLines, LinesOfALostChipStayLostUntilReleased) {
  CHECK_TRUE(lines.request_output(1, true) == Status::ok);
  CHECK_TRUE(lines.request_input(2, Edges::both) == Status::ok);
  backend.unplug();
  CHECK_TRUE(lines.set(1, false) == Status::device_lost);
  CHECK_TRUE(lines.request_output(3, true) == Status::device_lost);
  backend.plug();
  CHECK_TRUE(lines.set(1, false) == Status::device_lost);  // a request opens the chip, nothing else
  CHECK_TRUE(lines.request_output(3, true) == Status::ok);
  LONGS_EQUAL(2, backend.opens());
  CHECK_TRUE(lines.set(3, false) == Status::ok);
  CHECK_TRUE(lines.set(1, false) == Status::device_lost);
  CHECK_TRUE(lines.request_output(1, true) == Status::no_capacity);
  CHECK_TRUE(lines.release(1) == Status::ok);
  CHECK_TRUE(lines.request_output(1, true) == Status::ok);
  LineEdge edge;
  CHECK_TRUE(lines.wait_edge({0}, edge) == Status::no_data);
  CHECK_TRUE(lines.release(2) == Status::ok);
  CHECK_TRUE(lines.request_input(2, Edges::both) == Status::ok);
  backend.drive(2, true, now());
  CHECK_TRUE(lines.wait_edge({0}, edge) == Status::ok);
  LONGS_EQUAL(1, edge.sequence);
}

/// While line 6 is looked at, an edge comes on line 5, which was found empty just before, and then one on line 6.
TEST(GpiodLines, EdgesThatComeDuringTheLookKeepTheirOrder) {
  CHECK_TRUE(lines.request_input(5, Edges::rising) == Status::ok);
  CHECK_TRUE(lines.request_input(6, Edges::rising) == Status::ok);
  backend.before_read = [](FakeGpioBackend& fake, std::uint32_t offset) {
    if (offset != 6) return;
    fake.drive(5, true, now());
    fake.drive(6, true, now());
  };
  LineEdge edge;
  CHECK_TRUE(lines.wait_edge({0}, edge) == Status::ok);
  LONGS_EQUAL(5, edge.offset);
  CHECK_TRUE(lines.wait_edge({0}, edge) == Status::ok);
  LONGS_EQUAL(6, edge.offset);
  CHECK_TRUE(lines.wait_edge({0}, edge) == Status::no_data);
}

TEST(GpiodLines, ManyUnreadEdgesOfTwoLinesComeInOrder) {
  CHECK_TRUE(lines.request_input(5, Edges::both) == Status::ok);
  CHECK_TRUE(lines.request_input(6, Edges::both) == Status::ok);
  std::uint32_t driven = 0;
  LineEdge edge;
  Time last;
  std::uint32_t sequence[8] = {};
  // 15 new edges a line for each one read: the buffers overflow, and losses show.
  std::uint32_t lost = 0;
  for (int round = 0; round < 40; ++round) {
    for (int i = 0; i < 15; ++i, ++driven) {
      backend.drive(5, driven % 2 == 0, now());
      backend.drive(6, driven % 2 == 0, now());
    }
    CHECK_TRUE(lines.wait_edge({0}, edge) == Status::ok);
    CHECK_TRUE(edge.time > last);
    last = edge.time;
    lost += edge.sequence - sequence[edge.offset] - 1;
    sequence[edge.offset] = edge.sequence;
  }
  std::uint32_t read = 40;
  for (; lines.wait_edge({0}, edge) == Status::ok; ++read) {
    CHECK_TRUE(edge.time > last);
    last = edge.time;
    lost += edge.sequence - sequence[edge.offset] - 1;
    sequence[edge.offset] = edge.sequence;
  }
  CHECK_TRUE(lost > 0);
  LONGS_EQUAL(2 * driven, read + lost);
}

TEST(GpiodLines, WithoutCountsAFullBufferShowsAsALoss) {
  FakeGpioBackend uncounted{8, FakeGpioBackend::Api::v1};
  GpiodLines old{uncounted};
  CHECK_TRUE(old.open_path("fake") == Status::ok);
  CHECK_TRUE(old.request_input(1, Edges::both) == Status::ok);
  LineEdge edge;
  for (int i = 0; i < 15; ++i) uncounted.drive(1, i % 2 == 0, now());
  for (std::uint32_t i = 1; i <= 15; ++i) {
    CHECK_TRUE(old.wait_edge({0}, edge) == Status::ok);
    LONGS_EQUAL(i, edge.sequence);
  }
  for (int i = 15; i < 40; ++i) uncounted.drive(1, i % 2 == 0, now());
  for (std::uint32_t i = 16; i <= 31; ++i) {
    CHECK_TRUE(old.wait_edge({0}, edge) == Status::ok);
    LONGS_EQUAL(i, edge.sequence);
  }
  CHECK_TRUE(old.wait_edge({0}, edge) == Status::no_data);
  uncounted.drive(1, true, now());
  CHECK_TRUE(old.wait_edge({0}, edge) == Status::ok);
  LONGS_EQUAL(33, edge.sequence);
}

TEST_GROUP(GpioChip) {
  std::string path = "unchanged";
  std::string problem;
};

TEST(GpioChip, NumbersAreRefused) {
  CHECK_TRUE(relnav::platform::linux::find_gpio_chip("0", path, problem) == Status::invalid_argument);
  CHECK_TRUE(contains(problem, "\"0\""));
  CHECK_TRUE(relnav::platform::linux::find_gpio_chip("", path, problem) == Status::invalid_argument);
  STRCMP_EQUAL("unchanged", path.c_str());
}

TEST(GpioChip, WhatIsNoChipSaysSo) {
  CHECK_TRUE(relnav::platform::linux::find_gpio_chip("/dev/null", path, problem) == Status::unsupported);
  STRCMP_EQUAL("/dev/null: is not a GPIO chip; expected a GPIO chip", problem.c_str());
  CHECK_TRUE(relnav::platform::linux::find_gpio_chip("/dev/nothing", path, problem) == Status::no_data);
  CHECK_TRUE(contains(problem, "/dev/nothing: cannot be opened: No such file"));
  CHECK_TRUE(relnav::platform::linux::find_gpio_chip("no such label", path, problem) != Status::ok);
  CHECK_TRUE(contains(problem, "\"no such label\""));
  STRCMP_EQUAL("unchanged", path.c_str());
}

TEST_GROUP(GpiodBackend) {
  std::unique_ptr<relnav::platform::linux::GpioBackend> backend = relnav::platform::linux::make_gpiod_backend();
};

TEST(GpiodBackend, RefusesWhatIsNoChip) {
  CHECK_TRUE(backend->open("/dev/null") != Status::ok);
  CHECK_TRUE(contains(backend->problem(), "/dev/null: "));
  CHECK_TRUE(backend->open("/dev/nothing") != Status::ok);
  LONGS_EQUAL(0, backend->line_count());
}
