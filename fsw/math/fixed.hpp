#pragma once
#include <cstdint>
#include <limits>

#include <Eigen/Core>

namespace relnav {

/// Signed fixed-point number of 64 bits, FractionBits of them behind the point, for processors without a
/// floating-point unit. Q16.47 (FractionBits = 47) reaches +-65536 in steps of 7.1e-15.
/// Operations round to nearest (halves away from zero) and saturate. What has saturated, was divided by zero or had no
/// root carries a flag through all that is computed from it, as a NaN would: overflowed(). 64-bit integer operations
/// only, the same bits on every target.
template <int FractionBits>
class Fixed {
  static_assert(FractionBits > 0 && FractionBits < 62);

 public:
  constexpr Fixed() = default;
  constexpr Fixed(int value)  // NOLINT(google-explicit-constructor): numbers in formulas
      : Fixed(from_magnitude(magnitude_of(value), (magnitude_of(value) >> (63 - FractionBits)) == 0U, FractionBits,
                             value < 0, false)) {}
  /// Nearest; saturates. NaN gives a flagged zero.
  constexpr explicit Fixed(double value) {
    const double scaled = value * static_cast<double>(one);
    constexpr double bound = 9223372036854774784.0;  // largest double under 2^63
    if (scaled >= -bound && scaled <= bound) {
      raw_ = static_cast<std::int64_t>(scaled);
      const double rest = scaled - static_cast<double>(raw_);  // exact, where scaled + 0.5 would be rounded
      if (rest >= 0.5) ++raw_;
      if (rest <= -0.5) --raw_;
    } else {
      raw_ = scaled > 0.0 ? most : (scaled < 0.0 ? -most : 0);
      overflowed_ = true;
    }
  }

  [[nodiscard]] static constexpr Fixed from_raw(std::int64_t raw) { return Fixed(raw, false); }
  [[nodiscard]] constexpr std::int64_t raw() const { return raw_; }
  [[nodiscard]] constexpr bool overflowed() const { return overflowed_; }
  [[nodiscard]] constexpr explicit operator double() const {
    return static_cast<double>(raw_) / static_cast<double>(one);
  }

  constexpr Fixed operator-() const { return Fixed(-raw_, overflowed_); }
  constexpr Fixed& operator+=(Fixed b) { return *this = *this + b; }
  constexpr Fixed& operator-=(Fixed b) { return *this = *this - b; }
  constexpr Fixed& operator*=(Fixed b) { return *this = *this * b; }
  constexpr Fixed& operator/=(Fixed b) { return *this = *this / b; }

  friend constexpr Fixed operator+(Fixed a, Fixed b) {
    const bool flagged = a.overflowed_ || b.overflowed_;
    if (b.raw_ > 0 && a.raw_ > most - b.raw_) return Fixed(most, true);
    if (b.raw_ < 0 && a.raw_ < -most - b.raw_) return Fixed(-most, true);
    return Fixed(a.raw_ + b.raw_, flagged);
  }
  friend constexpr Fixed operator-(Fixed a, Fixed b) { return a + (-b); }

  friend constexpr Fixed operator*(Fixed a, Fixed b) {
    const std::uint64_t x = magnitude_of(a.raw_);
    const std::uint64_t y = magnitude_of(b.raw_);
    // 64 x 64 -> 128 bits from four products of 32 bits.
    const std::uint64_t x0 = x & low_half, x1 = x >> 32U, y0 = y & low_half, y1 = y >> 32U;
    const std::uint64_t middle = x1 * y0 + ((x0 * y0) >> 32U);
    const std::uint64_t middle2 = x0 * y1 + (middle & low_half);
    std::uint64_t high = x1 * y1 + (middle >> 32U) + (middle2 >> 32U);
    std::uint64_t low = (middle2 << 32U) | ((x0 * y0) & low_half);
    constexpr std::uint64_t half = std::uint64_t{1} << (FractionBits - 1);
    low += half;
    if (low < half) ++high;
    const std::uint64_t product = (high << (64 - FractionBits)) | (low >> FractionBits);
    return from_magnitude(product, (high >> FractionBits) == 0U, 0, (a.raw_ < 0) != (b.raw_ < 0),
                          a.overflowed_ || b.overflowed_);
  }

  friend constexpr Fixed operator/(Fixed a, Fixed b) {
    const bool negative = (a.raw_ < 0) != (b.raw_ < 0);
    if (b.raw_ == 0) return Fixed(negative ? -most : most, true);
    const std::uint64_t n = magnitude_of(a.raw_);
    const std::uint64_t d = magnitude_of(b.raw_);
    // Long division of n 2^FractionBits by d; both are below 2^63, so a doubled remainder fits.
    std::uint64_t remainder = n % d;
    std::uint64_t quotient = n / d;
    bool fits = true;
    for (int bit = 0; bit < FractionBits; ++bit) {
      fits = fits && (quotient >> 62U) == 0U;
      remainder <<= 1U;
      quotient <<= 1U;
      if (remainder >= d) {
        remainder -= d;
        quotient |= 1U;
      }
    }
    if (remainder >= d - remainder) ++quotient;
    return from_magnitude(quotient, fits, 0, negative, a.overflowed_ || b.overflowed_);
  }

  friend constexpr bool operator==(Fixed a, Fixed b) { return a.raw_ == b.raw_; }
  friend constexpr bool operator<(Fixed a, Fixed b) { return a.raw_ < b.raw_; }
  friend constexpr bool operator>(Fixed a, Fixed b) { return a.raw_ > b.raw_; }
  friend constexpr bool operator<=(Fixed a, Fixed b) { return a.raw_ <= b.raw_; }
  friend constexpr bool operator>=(Fixed a, Fixed b) { return a.raw_ >= b.raw_; }

  friend constexpr Fixed abs(Fixed a) { return Fixed(a.raw_ < 0 ? -a.raw_ : a.raw_, a.overflowed_); }

  /// Rounded down. A negative argument gives a flagged zero.
  friend constexpr Fixed sqrt(Fixed a) {
    if (a.raw_ < 0) return Fixed(0, true);
    // Digit by digit: the root of raw 2^FractionBits, whose bits are brought down in pairs.
    const auto x = static_cast<std::uint64_t>(a.raw_);
    std::uint64_t remainder = 0;
    std::uint64_t root = 0;
    constexpr int pairs = (63 + FractionBits + 1) / 2;
    for (int pair = pairs - 1; pair >= 0; --pair) {
      const int place = 2 * pair - FractionBits;  // of the pair's lower bit in x
      std::uint64_t bits = 0;
      if (place >= 0) {
        bits = (x >> static_cast<unsigned>(place)) & 3U;
      } else if (place == -1) {
        bits = (x & 1U) << 1U;
      }
      remainder = (remainder << 2U) | bits;
      root <<= 1U;
      const std::uint64_t trial = (root << 1U) | 1U;
      if (remainder >= trial) {
        remainder -= trial;
        root |= 1U;
      }
    }
    return Fixed(static_cast<std::int64_t>(root), a.overflowed_);
  }

 private:
  static constexpr std::int64_t one = std::int64_t{1} << FractionBits;
  static constexpr std::int64_t most = std::numeric_limits<std::int64_t>::max();  // -most at the other end
  static constexpr std::uint64_t low_half = 0xFFFFFFFFU;

  constexpr Fixed(std::int64_t raw, bool overflowed) : raw_(raw), overflowed_(overflowed) {}

  [[nodiscard]] static constexpr std::uint64_t magnitude_of(std::int64_t raw) {
    return raw < 0 ? static_cast<std::uint64_t>(-raw) : static_cast<std::uint64_t>(raw);
  }
  [[nodiscard]] static constexpr Fixed from_magnitude(std::uint64_t magnitude, bool fits, int shift, bool negative,
                                                      bool flagged) {
    if (!fits || (magnitude >> 63U) != 0U) return Fixed(negative ? -most : most, true);
    const auto raw = static_cast<std::int64_t>(magnitude << static_cast<unsigned>(shift));
    return Fixed(negative ? -raw : raw, flagged);
  }

  std::int64_t raw_ = 0;
  bool overflowed_ = false;
};

/// What the solvers use: lengths over the range, model points over the target's size, attitudes in MSR's bounds.
using FixedQ47 = Fixed<47>;

}  // namespace relnav

namespace Eigen {

template <int FractionBits>
struct NumTraits<relnav::Fixed<FractionBits>> : GenericNumTraits<relnav::Fixed<FractionBits>> {
  using Real = relnav::Fixed<FractionBits>;
  using NonInteger = relnav::Fixed<FractionBits>;
  using Nested = relnav::Fixed<FractionBits>;
  using Literal = relnav::Fixed<FractionBits>;
  // NOLINTBEGIN(readability-identifier-naming): Eigen's names
  enum {
    IsComplex = 0,
    IsInteger = 0,
    IsSigned = 1,
    RequireInitialization = 1,
    ReadCost = 2,
    AddCost = 4,
    MulCost = 12,
  };
  // NOLINTEND(readability-identifier-naming)
};

}  // namespace Eigen
