#pragma once
/// Contract of hal::CommandSource. A harness has:
///   hal::CommandSource& source();                            open, nothing waiting
///   void arrive(const std::vector<std::uint8_t>& packet);    at the far end of the source; it is there on return
///   bool fail_next(Status status);                           the next receive() meets this fault; false: cannot be played
///   Time now(); Duration slack();                            as for a camera
#include <array>
#include <cstdint>
#include <vector>

#include "fsw/base/time.hpp"
#include "hal/command_source.hpp"
#include "tests/contract/clause.hpp"

namespace relnav::command_source_contract {

using Packet = std::vector<std::uint8_t>;

inline Packet sample(std::size_t size, unsigned seed) {
  Packet bytes(size);
  for (std::size_t i = 0; i < size; ++i) bytes[i] = static_cast<std::uint8_t>((i * 29U + seed * 13U) & 0xFFU);
  return bytes;
}

/// receive() into a buffer of this size; checks that `bytes` changes on ok only, and that nothing behind the buffer does.
template <typename Harness>
Status receive(Harness& harness, std::size_t room, Packet& packet) {
  std::array<std::uint8_t, 2048> memory{};
  memory.fill(0xA5);
  std::size_t bytes = 4711;
  const Status status = harness.source().receive(std::span(memory).first(room), bytes);
  if (status == Status::ok) {
    CHECK_TRUE(bytes >= 1 && bytes <= room);
    packet.assign(memory.begin(), memory.begin() + static_cast<std::ptrdiff_t>(bytes));
  } else {
    LONGS_EQUAL(4711, bytes);
  }
  for (std::size_t i = room; i < memory.size(); ++i) LONGS_EQUAL(0xA5, memory[i]);
  return status;
}

template <typename Harness>
void CMD_1_nothing_to_give_is_no_data_at_once(Harness& harness) {
  Packet packet;
  const Time before = harness.now();
  for (int i = 0; i < 3; ++i) CHECK_TRUE(receive(harness, 256, packet) == Status::no_data);
  CHECK_TRUE((harness.now() - before).ns <= harness.slack().ns);
}

template <typename Harness>
void CMD_2_whole_packets_of_any_size(Harness& harness) {
  for (const std::size_t size :
       {std::size_t{1}, std::size_t{13}, std::size_t{17}, std::size_t{255}, std::size_t{256}}) {
    const Packet sent = sample(size, 1);
    harness.arrive(sent);
    Packet packet;
    CHECK_TRUE(receive(harness, 256, packet) == Status::ok);
    CHECK_TRUE(packet == sent);
    CHECK_TRUE(receive(harness, 256, packet) == Status::no_data);
  }
}

template <typename Harness>
void CMD_3_order_and_bounds_are_kept(Harness& harness) {
  for (unsigned i = 0; i < 8; ++i) harness.arrive(sample(10 + i, i));
  for (unsigned i = 0; i < 8; ++i) {
    Packet packet;
    CHECK_TRUE(receive(harness, 256, packet) == Status::ok);
    CHECK_TRUE(packet == sample(10 + i, i));
  }
  Packet packet;
  CHECK_TRUE(receive(harness, 256, packet) == Status::no_data);
}

template <typename Harness>
void CMD_4_too_long_a_packet_is_gone_and_said(Harness& harness) {
  harness.arrive(sample(65, 2));
  harness.arrive(sample(64, 3));
  Packet packet;
  CHECK_TRUE(receive(harness, 64, packet) == Status::no_capacity);
  CHECK_TRUE(receive(harness, 64, packet) == Status::ok);
  CHECK_TRUE(packet == sample(64, 3));
  CHECK_TRUE(receive(harness, 64, packet) == Status::no_data);
}

template <typename Harness>
void CMD_5_a_fault_does_not_spoil_the_next_call(Harness& harness) {
  if (!harness.fail_next(Status::io_error)) return;
  harness.arrive(sample(20, 4));
  Packet packet;
  CHECK_TRUE(receive(harness, 256, packet) == Status::io_error);
  CHECK_TRUE(receive(harness, 256, packet) == Status::ok);
  CHECK_TRUE(packet == sample(20, 4));
}

}  // namespace relnav::command_source_contract

#define RELNAV_COMMAND_SOURCE_CONTRACT(group, Harness)                                            \
  TEST_GROUP(group) { Harness harness; };                                                         \
  RELNAV_CLAUSE(group, relnav::command_source_contract, CMD_1_nothing_to_give_is_no_data_at_once) \
  RELNAV_CLAUSE(group, relnav::command_source_contract, CMD_2_whole_packets_of_any_size)          \
  RELNAV_CLAUSE(group, relnav::command_source_contract, CMD_3_order_and_bounds_are_kept)          \
  RELNAV_CLAUSE(group, relnav::command_source_contract, CMD_4_too_long_a_packet_is_gone_and_said) \
  RELNAV_CLAUSE(group, relnav::command_source_contract, CMD_5_a_fault_does_not_spoil_the_next_call)
