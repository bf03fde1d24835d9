#pragma once
#include <cstdint>

namespace relnav::hil {

/// Counter to random bits (lowbias32 of Wellons' hash prospector, 2018): the same wherever and in whatever order it is asked.
constexpr std::uint32_t hashed(std::uint32_t x) {
  x ^= x >> 16U;
  x *= 0x7feb352dU;
  x ^= x >> 15U;
  x *= 0x846ca68bU;
  x ^= x >> 16U;
  return x;
}
constexpr std::uint32_t hashed(std::uint32_t x, std::uint32_t y) { return hashed(x ^ hashed(y + 0x9e3779b9U)); }
/// On [0, 1).
constexpr float unit_hash(std::uint32_t x) { return static_cast<float>(hashed(x) >> 8U) * 0x1p-24F; }
constexpr float unit_hash(std::uint32_t x, std::uint32_t y) {
  return static_cast<float>(hashed(x, y) >> 8U) * 0x1p-24F;
}
constexpr std::uint32_t folded(std::uint64_t seed) {
  return hashed(static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32U));
}

}  // namespace relnav::hil
