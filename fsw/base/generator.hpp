#pragma once
#include <cstdint>

namespace relnav {

/// Seeded pseudo-random generator, PCG-XSH-RR 64/32 (O'Neill, HMC-CS-2014-0905, 2014): the same sequence on every target.
class Generator {
 public:
  explicit constexpr Generator(std::uint64_t seed, std::uint64_t stream = 0x5DEECE66DULL)
      : state_(0), increment_((stream << 1U) | 1U) {
    static_cast<void>(next());
    state_ += seed;
    static_cast<void>(next());
  }

  /// Uniform on [0, 2^32).
  [[nodiscard]] constexpr std::uint32_t next() {
    const std::uint64_t old = state_;
    state_ = old * 6364136223846793005ULL + increment_;
    const auto xorshifted = static_cast<std::uint32_t>(((old >> 18U) ^ old) >> 27U);
    const auto rot = static_cast<std::uint32_t>(old >> 59U);
    return (xorshifted >> rot) | (xorshifted << ((32U - rot) & 31U));
  }

  /// Nearly uniform on [0, bound), bound > 0 (multiply-shift; bias below bound / 2^32). One draw, bounded time.
  [[nodiscard]] constexpr std::uint32_t below(std::uint32_t bound) {
    return static_cast<std::uint32_t>((static_cast<std::uint64_t>(next()) * bound) >> 32U);
  }

  /// Uniform on [0, 1), 32 bits of resolution.
  [[nodiscard]] constexpr double uniform() { return static_cast<double>(next()) * 0x1p-32; }

 private:
  std::uint64_t state_;
  std::uint64_t increment_;
};

}  // namespace relnav
