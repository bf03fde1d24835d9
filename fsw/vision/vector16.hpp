#pragma once
/// 16-byte vectors through the compiler's vector extension: one register on SSE2 and NEON, plain code elsewhere.
/// Integer operations only, so every target gives the same bits.
#include <cstdint>
#include <cstring>

namespace relnav::vision {

using U8x16 = std::uint8_t __attribute__((vector_size(16)));
using I16x8 = std::int16_t __attribute__((vector_size(16)));
using I32x4 = std::int32_t __attribute__((vector_size(16)));

template <typename Vector, typename Element>
[[nodiscard]] inline Vector load(const Element* from) {
  Vector v;
  std::memcpy(&v, from, sizeof v);
  return v;
}
template <typename Vector, typename Element>
inline void store(Element* to, const Vector& v) {
  std::memcpy(to, &v, sizeof v);
}

[[nodiscard]] inline U8x16 min(U8x16 a, U8x16 b) { return a < b ? a : b; }
[[nodiscard]] inline U8x16 max(U8x16 a, U8x16 b) { return a > b ? a : b; }
/// max(a - b, 0)
[[nodiscard]] inline U8x16 subtract_saturated(U8x16 a, U8x16 b) { return max(a, b) - b; }
[[nodiscard]] inline U8x16 splat(std::uint8_t value) { return U8x16{} + value; }

/// Bit i is the top bit of lane i.
[[nodiscard]] inline std::uint32_t lane_bits(U8x16 v) {
#if defined(__SSE2__)
  using Bytes = char __attribute__((vector_size(16)));
  return static_cast<std::uint32_t>(__builtin_ia32_pmovmskb128(reinterpret_cast<Bytes>(v)));
#else
  std::uint32_t bits = 0;
  for (std::uint32_t i = 0; i < 16; ++i) bits |= static_cast<std::uint32_t>(v[i] >> 7U) << i;
  return bits;
#endif
}

/// Whether any lane of a comparison's result (0 or 0xFF a lane) is set.
[[nodiscard]] inline bool any(U8x16 mask) {
#if defined(__SSE2__)
  return lane_bits(mask) != 0;
#else
  std::uint64_t halves[2];
  std::memcpy(halves, &mask, sizeof halves);
  return (halves[0] | halves[1]) != 0;
#endif
}

/// Lanes 0 to 7 (half 0) or 8 to 15 (half 1).
[[nodiscard]] inline I16x8 widen(U8x16 v, int half) {
  using Half = std::uint8_t __attribute__((vector_size(8)));
  Half part;
  std::memcpy(&part, reinterpret_cast<const char*>(&v) + 8 * half, sizeof part);
  return __builtin_convertvector(part, I16x8);
}

/// Lane i: a[2i] b[2i] + a[2i+1] b[2i+1]. Never both pairs -32768 * -32768.
[[nodiscard]] inline I32x4 multiply_add_pairs(I16x8 a, I16x8 b) {
#if defined(__SSE2__)
  return __builtin_ia32_pmaddwd128(a, b);
#else
  I32x4 sum;
  for (int i = 0; i < 4; ++i) sum[i] = a[2 * i] * b[2 * i] + a[2 * i + 1] * b[2 * i + 1];
  return sum;
#endif
}

[[nodiscard]] inline std::int32_t sum_of_lanes(I32x4 v) { return (v[0] + v[1]) + (v[2] + v[3]); }

}  // namespace relnav::vision
