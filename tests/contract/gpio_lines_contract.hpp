#pragma once
/// Contract of hal::GpioLines. A harness has:
///   hal::GpioLines& lines();                          nothing requested
///   std::uint32_t line_a(), line_b(), no_line();      two lines that exist, one that does not
///   bool level(std::uint32_t offset);                 the level on the line, seen from outside
///   bool drive(std::uint32_t offset, bool level);     from outside, each later than the one before; false: cannot be played
///   std::size_t unread_edges();                       how many edges are kept for a reader
///   bool lose_device(); void restore_device();
///   Duration wait(); Time now(); Duration slack();    as for a camera
#include <cstddef>
#include <cstdint>

#include "hal/gpio_lines.hpp"
#include "tests/contract/clause.hpp"

namespace relnav::gpio_lines_contract {

using hal::Edges;
using hal::LineEdge;

template <typename Harness>
void GPIO_1_lines_not_requested_are_not_configured(Harness& harness) {
  const std::uint32_t a = harness.line_a();
  const bool before = harness.level(a);
  bool level = !before;
  CHECK_TRUE(harness.lines().set(a, !before) == Status::not_configured);
  CHECK_TRUE(harness.level(a) == before);
  CHECK_TRUE(harness.lines().get(a, level) == Status::not_configured);
  CHECK_TRUE(level == !before);
  CHECK_TRUE(harness.lines().release(a) == Status::not_configured);
  CHECK_TRUE(harness.lines().set(harness.no_line(), true) == Status::not_configured);
  CHECK_TRUE(harness.lines().release(harness.no_line()) == Status::not_configured);
}

template <typename Harness>
void GPIO_2_bad_requests_are_refused(Harness& harness) {
  CHECK_TRUE(harness.lines().request_output(harness.no_line(), false) == Status::invalid_argument);
  CHECK_TRUE(harness.lines().request_input(harness.no_line(), Edges::both) == Status::invalid_argument);
  CHECK_TRUE(harness.lines().request_output(harness.line_a(), true) == Status::ok);
  CHECK_TRUE(harness.lines().request_output(harness.line_a(), false) == Status::no_capacity);
  CHECK_TRUE(harness.lines().request_input(harness.line_a(), Edges::both) == Status::no_capacity);
  CHECK_TRUE(harness.level(harness.line_a()));
}

template <typename Harness>
void GPIO_3_output_starts_at_its_initial_level(Harness& harness) {
  for (const bool initial : {true, false, true}) {
    CHECK_TRUE(harness.lines().request_output(harness.line_a(), initial) == Status::ok);
    CHECK_TRUE(harness.level(harness.line_a()) == initial);
    CHECK_TRUE(harness.lines().release(harness.line_a()) == Status::ok);
  }
}

template <typename Harness>
void GPIO_4_set_takes_effect_on_its_own_line(Harness& harness) {
  CHECK_TRUE(harness.lines().request_output(harness.line_a(), false) == Status::ok);
  CHECK_TRUE(harness.lines().request_output(harness.line_b(), false) == Status::ok);
  for (const bool level : {true, false, true, true}) {
    CHECK_TRUE(harness.lines().set(harness.line_a(), level) == Status::ok);
    CHECK_TRUE(harness.level(harness.line_a()) == level);
    bool read = !level;
    CHECK_TRUE(harness.lines().get(harness.line_a(), read) == Status::ok);
    CHECK_TRUE(read == level);
    CHECK_FALSE(harness.level(harness.line_b()));
  }
}

template <typename Harness>
void GPIO_4_set_of_an_input_is_refused(Harness& harness) {
  CHECK_TRUE(harness.lines().request_input(harness.line_a(), Edges::none) == Status::ok);
  const bool before = harness.level(harness.line_a());
  CHECK_TRUE(harness.lines().set(harness.line_a(), !before) == Status::invalid_argument);
  CHECK_TRUE(harness.level(harness.line_a()) == before);
}

template <typename Harness>
void GPIO_5_get_reads_the_line(Harness& harness) {
  CHECK_TRUE(harness.lines().request_input(harness.line_a(), Edges::none) == Status::ok);
  for (const bool level : {true, false, true}) {
    if (!harness.drive(harness.line_a(), level)) return;
    bool read = !level;
    CHECK_TRUE(harness.lines().get(harness.line_a(), read) == Status::ok);
    CHECK_TRUE(read == level);
  }
}

template <typename Harness>
void GPIO_6_edges_come_once_in_order_and_as_asked(Harness& harness) {
  const std::uint32_t a = harness.line_a();
  const std::uint32_t b = harness.line_b();
  CHECK_TRUE(harness.lines().request_input(a, Edges::rising) == Status::ok);
  CHECK_TRUE(harness.lines().request_input(b, Edges::falling) == Status::ok);
  for (int i = 0; i < 3; ++i) {
    if (!harness.drive(a, true)) return;
    CHECK_TRUE(harness.drive(b, true));
    CHECK_TRUE(harness.drive(b, false));
    CHECK_TRUE(harness.drive(a, false));
  }
  Time last{-1};
  for (std::uint32_t i = 0; i < 6; ++i) {
    LineEdge edge;
    CHECK_TRUE(harness.lines().wait_edge(harness.wait(), edge) == Status::ok);
    LONGS_EQUAL(i % 2 == 0 ? a : b, edge.offset);
    CHECK_TRUE(edge.rising == (i % 2 == 0));
    CHECK_TRUE(edge.time > last);
    LONGS_EQUAL(i / 2 + 1, edge.sequence);
    last = edge.time;
  }
  LineEdge edge;
  CHECK_TRUE(harness.lines().wait_edge(Duration{0}, edge) == Status::no_data);
}

template <typename Harness>
void GPIO_6_both_and_none(Harness& harness) {
  CHECK_TRUE(harness.lines().request_input(harness.line_a(), Edges::both) == Status::ok);
  CHECK_TRUE(harness.lines().request_input(harness.line_b(), Edges::none) == Status::ok);
  if (!harness.drive(harness.line_a(), true)) return;
  CHECK_TRUE(harness.drive(harness.line_b(), true));
  CHECK_TRUE(harness.drive(harness.line_a(), false));
  LineEdge edge;
  CHECK_TRUE(harness.lines().wait_edge(harness.wait(), edge) == Status::ok);
  CHECK_TRUE(edge.rising);
  CHECK_TRUE(harness.lines().wait_edge(harness.wait(), edge) == Status::ok);
  CHECK_FALSE(edge.rising);
  LONGS_EQUAL(harness.line_a(), edge.offset);
  CHECK_TRUE(harness.lines().wait_edge(Duration{0}, edge) == Status::no_data);
}

template <typename Harness>
void GPIO_7_never_waits_longer_than_asked(Harness& harness) {
  CHECK_TRUE(harness.lines().request_input(harness.line_a(), Edges::both) == Status::ok);
  for (const std::int64_t wait_ns : {std::int64_t{0}, std::int64_t{5'000'000}}) {
    LineEdge edge;
    edge.sequence = 4711;
    const Time before = harness.now();
    const Status status = harness.lines().wait_edge(Duration{wait_ns}, edge);
    CHECK_TRUE(status == Status::no_data || status == Status::timeout);
    CHECK_TRUE((harness.now() - before).ns <= wait_ns + harness.slack().ns);
    LONGS_EQUAL(4711, edge.sequence);
  }
}

template <typename Harness>
void GPIO_8_lost_edges_show_as_a_gap(Harness& harness) {
  CHECK_TRUE(harness.lines().request_input(harness.line_a(), Edges::both) == Status::ok);
  const std::size_t kept = harness.unread_edges();
  for (std::size_t i = 0; i < kept + 4; ++i) {
    if (!harness.drive(harness.line_a(), i % 2 == 0)) return;
  }
  LineEdge edge;
  std::size_t read = 0;
  std::uint32_t last = 0;
  std::uint32_t missing = 0;
  while (harness.lines().wait_edge(Duration{0}, edge) == Status::ok) {
    missing += edge.sequence - last - 1;
    last = edge.sequence;
    ++read;
  }
  CHECK_TRUE(harness.drive(harness.line_a(), kept % 2 == 0));
  CHECK_TRUE(harness.lines().wait_edge(harness.wait(), edge) == Status::ok);
  missing += edge.sequence - last - 1;
  LONGS_EQUAL(kept, read);
  LONGS_EQUAL(4, missing);
}

template <typename Harness>
void GPIO_9_released_lines_start_anew(Harness& harness) {
  const std::uint32_t a = harness.line_a();
  CHECK_TRUE(harness.lines().request_input(a, Edges::both) == Status::ok);
  const bool can_drive = harness.drive(a, true);
  CHECK_TRUE(harness.lines().release(a) == Status::ok);
  CHECK_TRUE(harness.lines().release(a) == Status::not_configured);
  CHECK_TRUE(harness.lines().request_input(a, Edges::both) == Status::ok);
  LineEdge edge;
  CHECK_TRUE(harness.lines().wait_edge(Duration{0}, edge) == Status::no_data);
  if (can_drive) {
    CHECK_TRUE(harness.drive(a, false));
    CHECK_TRUE(harness.lines().wait_edge(harness.wait(), edge) == Status::ok);
    LONGS_EQUAL(1, edge.sequence);
  }
  CHECK_TRUE(harness.lines().release(a) == Status::ok);
  CHECK_TRUE(harness.lines().request_output(a, true) == Status::ok);
  CHECK_TRUE(harness.lines().set(a, false) == Status::ok);
}

template <typename Harness>
void GPIO_10_device_lost(Harness& harness) {
  const std::uint32_t a = harness.line_a();
  CHECK_TRUE(harness.lines().request_output(a, false) == Status::ok);
  if (!harness.lose_device()) return;
  bool level = true;
  LineEdge edge;
  CHECK_TRUE(harness.lines().set(a, true) == Status::device_lost);
  CHECK_TRUE(harness.lines().get(a, level) == Status::device_lost);
  CHECK_TRUE(level);
  CHECK_TRUE(harness.lines().wait_edge(Duration{0}, edge) == Status::device_lost);
  CHECK_TRUE(harness.lines().request_input(harness.line_b(), Edges::both) == Status::device_lost);
  CHECK_TRUE(harness.lines().release(a) == Status::ok);
  harness.restore_device();
  CHECK_TRUE(harness.lines().request_output(a, true) == Status::ok);
}

}  // namespace relnav::gpio_lines_contract

#define RELNAV_GPIO_LINES_CONTRACT(group, Harness)                                                 \
  TEST_GROUP(group) { Harness harness; };                                                          \
  RELNAV_CLAUSE(group, relnav::gpio_lines_contract, GPIO_1_lines_not_requested_are_not_configured) \
  RELNAV_CLAUSE(group, relnav::gpio_lines_contract, GPIO_2_bad_requests_are_refused)               \
  RELNAV_CLAUSE(group, relnav::gpio_lines_contract, GPIO_3_output_starts_at_its_initial_level)     \
  RELNAV_CLAUSE(group, relnav::gpio_lines_contract, GPIO_4_set_takes_effect_on_its_own_line)       \
  RELNAV_CLAUSE(group, relnav::gpio_lines_contract, GPIO_4_set_of_an_input_is_refused)             \
  RELNAV_CLAUSE(group, relnav::gpio_lines_contract, GPIO_5_get_reads_the_line)                     \
  RELNAV_CLAUSE(group, relnav::gpio_lines_contract, GPIO_6_edges_come_once_in_order_and_as_asked)  \
  RELNAV_CLAUSE(group, relnav::gpio_lines_contract, GPIO_6_both_and_none)                          \
  RELNAV_CLAUSE(group, relnav::gpio_lines_contract, GPIO_7_never_waits_longer_than_asked)          \
  RELNAV_CLAUSE(group, relnav::gpio_lines_contract, GPIO_8_lost_edges_show_as_a_gap)               \
  RELNAV_CLAUSE(group, relnav::gpio_lines_contract, GPIO_9_released_lines_start_anew)              \
  RELNAV_CLAUSE(group, relnav::gpio_lines_contract, GPIO_10_device_lost)
