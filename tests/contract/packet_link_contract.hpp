#pragma once
/// Contract of hal::PacketLink. A harness has:
///   hal::PacketLink& link();                          open and ready
///   std::vector<std::vector<std::uint8_t>> arrived(); what came out at the far end since the last call
///   void refuse_next();                               makes the next send() fail for want of room, where that can be played
#include <cstdint>
#include <vector>

#include "hal/packet_link.hpp"
#include "tests/contract/clause.hpp"

namespace relnav::packet_link_contract {

inline std::vector<std::uint8_t> sample(std::size_t size, unsigned seed) {
  std::vector<std::uint8_t> bytes(size);
  for (std::size_t i = 0; i < size; ++i) bytes[i] = static_cast<std::uint8_t>((i * 31U + seed * 17U) & 0xFFU);
  return bytes;
}

template <typename Harness>
void LNK_1_takes_whole_packets_of_any_allowed_size(Harness& harness) {
  for (const std::size_t size : {std::size_t{1}, std::size_t{2}, std::size_t{76}, std::size_t{1400},
                                 std::size_t{harness.link().max_packet_bytes()}}) {
    const auto packet = sample(size, 1);
    CHECK_TRUE(harness.link().send(packet) == Status::ok);
    const auto arrived = harness.arrived();
    LONGS_EQUAL(1, arrived.size());
    CHECK_TRUE(arrived[0] == packet);
  }
}

template <typename Harness>
void LNK_1_carries_telemetry_packets(Harness& harness) {
  CHECK_TRUE(harness.link().max_packet_bytes() >= 1400);
}

template <typename Harness>
void LNK_2_refuses_empty_and_oversized(Harness& harness) {
  CHECK_TRUE(harness.link().send({}) == Status::invalid_argument);
  CHECK_TRUE(harness.link().send(sample(harness.link().max_packet_bytes() + 1U, 2)) == Status::invalid_argument);
  LONGS_EQUAL(0, harness.arrived().size());
}

template <typename Harness>
void LNK_3_want_of_room_is_no_capacity(Harness& harness) {
  harness.refuse_next();
  CHECK_TRUE(harness.link().send(sample(100, 3)) == Status::no_capacity);
  LONGS_EQUAL(0, harness.arrived().size());
}

template <typename Harness>
void LNK_4_keeps_order_and_bounds(Harness& harness) {
  std::vector<std::vector<std::uint8_t>> packets;
  for (unsigned i = 0; i < 20; ++i) {
    packets.push_back(sample(10 + 7 * i, i));
    CHECK_TRUE(harness.link().send(packets.back()) == Status::ok);
  }
  CHECK_TRUE(harness.arrived() == packets);
}

template <typename Harness>
void LNK_5_keeps_no_reference(Harness& harness) {
  auto packet = sample(64, 5);
  const auto as_sent = packet;
  CHECK_TRUE(harness.link().send(packet) == Status::ok);
  for (std::uint8_t& byte : packet) byte = 0xAA;
  const auto arrived = harness.arrived();
  LONGS_EQUAL(1, arrived.size());
  CHECK_TRUE(arrived[0] == as_sent);
}

template <typename Harness>
void LNK_6_a_refused_packet_leaves_no_trace(Harness& harness) {
  harness.refuse_next();
  CHECK_TRUE(harness.link().send(sample(100, 6)) != Status::ok);
  const auto next = sample(50, 7);
  CHECK_TRUE(harness.link().send(next) == Status::ok);
  const auto arrived = harness.arrived();
  LONGS_EQUAL(1, arrived.size());
  CHECK_TRUE(arrived[0] == next);
}

}  // namespace relnav::packet_link_contract

/// Every clause but those that need a link without room.
#define RELNAV_PACKET_LINK_CONTRACT(group, Harness)                                                 \
  TEST_GROUP(group) { Harness harness; };                                                           \
  RELNAV_CLAUSE(group, relnav::packet_link_contract, LNK_1_takes_whole_packets_of_any_allowed_size) \
  RELNAV_CLAUSE(group, relnav::packet_link_contract, LNK_1_carries_telemetry_packets)               \
  RELNAV_CLAUSE(group, relnav::packet_link_contract, LNK_2_refuses_empty_and_oversized)             \
  RELNAV_CLAUSE(group, relnav::packet_link_contract, LNK_4_keeps_order_and_bounds)                  \
  RELNAV_CLAUSE(group, relnav::packet_link_contract, LNK_5_keeps_no_reference)

/// The rest, for a harness that has refuse_next().
#define RELNAV_PACKET_LINK_REFUSAL_CONTRACT(group)                                      \
  RELNAV_CLAUSE(group, relnav::packet_link_contract, LNK_3_want_of_room_is_no_capacity) \
  RELNAV_CLAUSE(group, relnav::packet_link_contract, LNK_6_a_refused_packet_leaves_no_trace)
