// An integer of 128 bits from two words, as the exact reference of fixed-point tests: 32-bit targets have no __int128.
// Two's complement; what leaves the range wraps. tests/unit/math/wide_test.cpp compares it with the compiler's.
#pragma once
#include <bit>
#include <cmath>
#include <compare>
#include <cstdint>

namespace relnav::test {

class Wide {
 public:
  constexpr Wide() = default;
  constexpr Wide(std::int64_t value)  // NOLINT(google-explicit-constructor): numbers in formulas
      : high_(value < 0 ? ~std::uint64_t{0} : 0), low_(static_cast<std::uint64_t>(value)) {}
  /// A whole number below 2^127.
  static Wide from_double(double value) {
    if (value < 0.0) return -from_double(-value);
    const double high = std::floor(std::ldexp(value, -64));
    return {static_cast<std::uint64_t>(high), static_cast<std::uint64_t>(value - std::ldexp(high, 64))};
  }

  /// The lower 64 bits.
  constexpr explicit operator std::int64_t() const { return static_cast<std::int64_t>(low_); }
  /// Nearest.
  explicit operator double() const {
    if (*this < 0) return -static_cast<double>(-*this);
    if (high_ == 0) return static_cast<double>(low_);
    // The upper 64 bits decide, and whether there is anything behind them.
    const int zeros = std::countl_zero(high_);
    const Wide top = *this << zeros;
    return std::ldexp(static_cast<double>(top.high_ | (top.low_ != 0 ? 1U : 0U)), 64 - zeros);
  }

  friend constexpr Wide operator+(Wide a, Wide b) {
    const std::uint64_t low = a.low_ + b.low_;
    return {a.high_ + b.high_ + (low < a.low_ ? 1U : 0U), low};
  }
  constexpr Wide operator-() const { return Wide(~high_, ~low_) + 1; }
  friend constexpr Wide operator-(Wide a, Wide b) { return a + -b; }
  friend constexpr Wide operator*(Wide a, Wide b) {
    Wide product;
    for (int k = 0; k < 128; k += 32) product = product + (times(a, b.digit(k)) << k);
    return product;
  }
  /// Of two numbers that are not negative; by zero it is zero.
  friend constexpr Wide operator/(Wide n, Wide d) {
    Wide quotient;
    Wide rest;
    const int bits = n.high_ != 0 ? 128 - std::countl_zero(n.high_) : 64 - std::countl_zero(n.low_);
    for (int k = bits - 1; k >= 0; --k) {
      rest = (rest << 1) + ((n.digit(k) & 1U) != 0 ? 1 : 0);
      quotient = quotient << 1;
      if (d == 0 || rest < d) continue;
      rest = rest - d;
      quotient = quotient + 1;
    }
    return quotient;
  }
  friend constexpr Wide operator<<(Wide a, int bits) {
    if (bits == 0) return a;
    if (bits >= 64) return {a.low_ << (bits - 64), 0};
    return {(a.high_ << bits) | (a.low_ >> (64 - bits)), a.low_ << bits};
  }

  friend constexpr bool operator==(Wide a, Wide b) = default;
  friend constexpr std::strong_ordering operator<=>(Wide a, Wide b) {
    if (a.high_ != b.high_) return static_cast<std::int64_t>(a.high_) <=> static_cast<std::int64_t>(b.high_);
    return a.low_ <=> b.low_;
  }

 private:
  constexpr Wide(std::uint64_t high, std::uint64_t low) : high_(high), low_(low) {}
  /// 32 bits, from bit k.
  [[nodiscard]] constexpr std::uint64_t digit(int k) const {
    const std::uint64_t bits = k >= 64 ? high_ >> (k - 64) : (low_ >> k) | (k > 0 ? high_ << (64 - k) : 0);
    return bits & 0xFFFFFFFFU;
  }
  static constexpr Wide times(Wide a, std::uint64_t digit) {
    const std::uint64_t p0 = a.digit(0) * digit;
    const std::uint64_t p1 = a.digit(32) * digit + (p0 >> 32);
    const std::uint64_t p2 = a.digit(64) * digit + (p1 >> 32);
    const std::uint64_t p3 = a.digit(96) * digit + (p2 >> 32);
    return {(p3 << 32) | (p2 & 0xFFFFFFFFU), (p1 << 32) | (p0 & 0xFFFFFFFFU)};
  }

  std::uint64_t high_ = 0;
  std::uint64_t low_ = 0;
};

}  // namespace relnav::test
