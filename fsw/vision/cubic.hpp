#pragma once
#include <array>
#include <cstdint>

namespace relnav::vision {

inline constexpr int cubic_fraction_bits = 8;  ///< of a position
inline constexpr int cubic_weight_bits = 10;   ///< of a weight

/// Weights of the pixels at -1, 0, 1, 2 for position t = t_q8 / 256, 0 <= t < 1: cubic convolution with a = -1/2 (Keys, IEEE
/// Trans. ASSP 29(6), 1981). Their sum is exactly one; a sum of levels with them stays within [-1/8, 9/8] of the range.
[[nodiscard]] constexpr std::array<std::int32_t, 4> cubic_weights(std::int32_t t_q8) {
  constexpr std::int32_t one = 1 << cubic_fraction_bits;
  const std::int32_t t2 = t_q8 * t_q8;
  const std::int32_t t3 = t2 * t_q8;
  const auto to_weight = [](std::int32_t twice_q24) { return (twice_q24 + (1 << 14)) >> 15; };
  const std::int32_t before = to_weight(2 * one * t2 - t3 - one * one * t_q8);
  const std::int32_t second = to_weight(4 * one * t2 - 3 * t3 + one * one * t_q8);
  const std::int32_t after = to_weight(t3 - one * t2);
  return {before, (1 << cubic_weight_bits) - before - second - after, second, after};
}

}  // namespace relnav::vision
