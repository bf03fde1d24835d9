#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace relnav {

namespace crc32_detail {

[[nodiscard]] consteval std::array<std::uint32_t, 256> make_table() {
  std::array<std::uint32_t, 256> table{};
  for (std::uint32_t byte = 0; byte < 256; ++byte) {
    std::uint32_t crc = byte;
    for (int bit = 0; bit < 8; ++bit) {
      crc = (crc & 1U) != 0U ? (crc >> 1U) ^ 0xEDB88320U : crc >> 1U;
    }
    table[byte] = crc;
  }
  return table;
}

inline constexpr std::array<std::uint32_t, 256> table = make_table();

}  // namespace crc32_detail

/// CRC-32 of IEEE 802.3 (polynomial 0x04C11DB7, start and final inversion all ones, reflected; check value 0xCBF43926): for what
/// is too long for crc16(). Pass the previous result as `crc` to go on over further bytes.
[[nodiscard]] constexpr std::uint32_t crc32(std::span<const std::uint8_t> bytes, std::uint32_t crc = 0) {
  std::uint32_t state = ~crc;
  for (const std::uint8_t byte : bytes) {
    state = (state >> 8U) ^ crc32_detail::table[(state ^ byte) & 0xFFU];
  }
  return ~state;
}

}  // namespace relnav
