#pragma once
/// Packets for the tests of telemetry.
#include <array>
#include <bit>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <tuple>
#include <type_traits>
#include <vector>

#include "fsw/base/crc16.hpp"
#include "fsw/telemetry/codec.hpp"

namespace packet_samples {

using Buffer = std::array<std::uint8_t, relnav::telemetry::max_packet_bytes>;

/// Sets every bit of an integer. Floats get their largest finite value, all bits but sign and one of the exponent.
inline void fill(std::uint8_t& x) { x = 0xFF; }
inline void fill(std::uint16_t& x) { x = 0xFFFF; }
inline void fill(std::uint32_t& x) { x = 0xFFFFFFFF; }
inline void fill(std::uint64_t& x) { x = 0x3B9AC9FFFFFFFFFF; }  // the latest time that a packet can carry
inline void fill(std::int32_t& x) { x = -1; }
inline void fill(std::int64_t& x) { x = -1; }
inline void fill(float& x) { x = std::numeric_limits<float>::max(); }
inline void fill(double& x) { x = std::numeric_limits<double>::max(); }
template <typename T, std::size_t N>
void fill(std::array<T, N>& xs) {
  for (T& x : xs) fill(x);
}

/// Every member of `value` that `fields` names gets all ones or all zeros.
template <typename Fields, typename Value>
void fill_all(const Fields& fields, Value& value, bool ones) {
  std::apply(
      [&](const auto&... f) {
        const auto one = [&](auto& member) {
          member = {};
          if (ones) fill(member);
        };
        (one(value.*(f.member)), ...);
      },
      fields);
}

/// Rewrites the CRC after a test changed bytes of a packet.
inline void seal(std::span<std::uint8_t> packet) {
  const std::uint16_t crc = relnav::crc16(packet.first(packet.size() - 2));
  packet[packet.size() - 2] = static_cast<std::uint8_t>(crc >> 8U);
  packet[packet.size() - 1] = static_cast<std::uint8_t>(crc & 0xFFU);
}

inline relnav::telemetry::FeatureEntry feature(std::uint16_t i) {
  return {i, static_cast<std::uint16_t>(i + 1U), 256 * i, -128 - i, 0.5F, static_cast<std::uint8_t>(i % 6)};
}

}  // namespace packet_samples
