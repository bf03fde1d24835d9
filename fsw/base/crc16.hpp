#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace relnav {

namespace crc16_detail {

[[nodiscard]] consteval std::array<std::uint16_t, 256> make_table() {
  std::array<std::uint16_t, 256> table{};
  for (std::uint32_t byte = 0; byte < 256; ++byte) {
    std::uint32_t crc = byte << 8U;
    for (int bit = 0; bit < 8; ++bit) {
      crc = (crc & 0x8000U) != 0U ? (crc << 1U) ^ 0x1021U : crc << 1U;
    }
    table[byte] = static_cast<std::uint16_t>(crc & 0xFFFFU);
  }
  return table;
}

inline constexpr std::array<std::uint16_t, 256> table = make_table();

}  // namespace crc16_detail

inline constexpr std::uint16_t crc16_start = 0xFFFF;

/// CRC-16/CCITT-FALSE (polynomial 0x1021, start 0xFFFF, not reflected, no final inversion; check value 0x29B1).
/// Pass the previous result as `crc` to go on over further bytes. Over data followed by its own CRC the result is 0.
[[nodiscard]] constexpr std::uint16_t crc16(std::span<const std::uint8_t> bytes, std::uint16_t crc = crc16_start) {
  for (const std::uint8_t byte : bytes) {
    const std::size_t index = ((static_cast<std::uint32_t>(crc) >> 8U) ^ byte) & 0xFFU;
    crc = static_cast<std::uint16_t>(((static_cast<std::uint32_t>(crc) << 8U) ^ crc16_detail::table[index]) & 0xFFFFU);
  }
  return crc;
}

}  // namespace relnav
