#pragma once
#include <cstdint>
#include <limits>
#include <type_traits>

#include <Eigen/Core>

namespace relnav {

/// Signed fixed-point number of 32 or 64 bits, FractionBits of them behind the point, for processors without a
/// floating-point unit. Formats, ranges and errors: docs/fixed-point.md.
/// Operations round to nearest (halves away from zero) and saturate. What has saturated, was divided by zero or had no
/// root carries a flag through all that is computed from it, as a NaN would: overflowed(). Integer operations of at most
/// 64 bits only, the same bits on every target.
template <int FractionBits, typename Raw = std::int64_t>
class Fixed {
  static_assert(std::is_same_v<Raw, std::int32_t> || std::is_same_v<Raw, std::int64_t>);
  static constexpr int digits = std::numeric_limits<Raw>::digits;
  static_assert(FractionBits > 0 && FractionBits < digits - 1);

 public:
  constexpr Fixed() = default;
  constexpr Fixed(int value)  // NOLINT(google-explicit-constructor): numbers in formulas
      : Fixed(scaled_up(magnitude_of(value), FractionBits, value < 0, false)) {}
  /// Nearest; saturates. NaN gives a flagged zero.
  constexpr explicit Fixed(double value) {
    const double scaled = value * static_cast<double>(one);
    constexpr double bound = static_cast<double>(most) + 0.5;  // 2^63 for 64 bits
    if (scaled > -bound && scaled < bound) {
      raw_ = static_cast<Raw>(scaled);
      const double rest = scaled - static_cast<double>(raw_);  // exact, where scaled + 0.5 would be rounded
      if (rest >= 0.5) ++raw_;
      if (rest <= -0.5) --raw_;
    } else {
      raw_ = scaled > 0.0 ? most : (scaled < 0.0 ? -most : 0);
      overflowed_ = true;
    }
  }
  /// From another format: nearest; saturates, and keeps the flag.
  template <int OtherBits, typename OtherRaw>
  constexpr explicit Fixed(Fixed<OtherBits, OtherRaw> other) {
    const std::uint64_t magnitude = magnitude_of(other.raw());
    const bool negative = other.raw() < 0;
    if constexpr (OtherBits > FractionBits) {
      constexpr int shift = OtherBits - FractionBits;
      *this =
          from_magnitude((magnitude + (std::uint64_t{1} << (shift - 1))) >> shift, true, negative, other.overflowed());
    } else {
      *this = scaled_up(magnitude, FractionBits - OtherBits, negative, other.overflowed());
    }
  }

  /// The lowest integer, which has no opposite, saturates: the numbers are symmetric about zero.
  [[nodiscard]] static constexpr Fixed from_raw(Raw raw) {
    return raw < -most ? Fixed(-most, true) : Fixed(raw, false);
  }
  [[nodiscard]] constexpr Raw raw() const { return raw_; }
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
    constexpr std::uint64_t half = std::uint64_t{1} << (FractionBits - 1);
    const bool negative = (a.raw_ < 0) != (b.raw_ < 0);
    const bool flagged = a.overflowed_ || b.overflowed_;
    if constexpr (digits < 32) {
      return from_magnitude((x * y + half) >> FractionBits, true, negative, flagged);
    } else {
      // 64 x 64 -> 128 bits from four products of 32 bits.
      const std::uint64_t x0 = x & low_half, x1 = x >> 32U, y0 = y & low_half, y1 = y >> 32U;
      const std::uint64_t middle = x1 * y0 + ((x0 * y0) >> 32U);
      const std::uint64_t middle2 = x0 * y1 + (middle & low_half);
      std::uint64_t high = x1 * y1 + (middle >> 32U) + (middle2 >> 32U);
      std::uint64_t low = (middle2 << 32U) | ((x0 * y0) & low_half);
      low += half;
      if (low < half) ++high;
      const std::uint64_t product = (high << (64 - FractionBits)) | (low >> FractionBits);
      return from_magnitude(product, (high >> FractionBits) == 0U, negative, flagged);
    }
  }

  friend constexpr Fixed operator/(Fixed a, Fixed b) {
    const bool negative = (a.raw_ < 0) != (b.raw_ < 0);
    if (b.raw_ == 0) return Fixed(negative ? -most : most, true);
    const std::uint64_t n = magnitude_of(a.raw_);
    const std::uint64_t d = magnitude_of(b.raw_);
    std::uint64_t quotient = 0;
    std::uint64_t remainder = 0;
    bool fits = true;
    if constexpr (digits < 32) {
      quotient = (n << FractionBits) / d;
      remainder = (n << FractionBits) % d;
    } else {
      // Long division of n 2^FractionBits by d; both are below 2^63, so a doubled remainder fits.
      remainder = n % d;
      quotient = n / d;
      for (int bit = 0; bit < FractionBits; ++bit) {
        fits = fits && (quotient >> 62U) == 0U;
        remainder <<= 1U;
        quotient <<= 1U;
        if (remainder >= d) {
          remainder -= d;
          quotient |= 1U;
        }
      }
    }
    if (remainder >= d - remainder) ++quotient;
    return from_magnitude(quotient, fits, negative, a.overflowed_ || b.overflowed_);
  }

  friend constexpr bool operator==(Fixed a, Fixed b) { return a.raw_ == b.raw_; }
  friend constexpr bool operator<(Fixed a, Fixed b) { return a.raw_ < b.raw_; }
  friend constexpr bool operator>(Fixed a, Fixed b) { return a.raw_ > b.raw_; }
  friend constexpr bool operator<=(Fixed a, Fixed b) { return a.raw_ <= b.raw_; }
  friend constexpr bool operator>=(Fixed a, Fixed b) { return a.raw_ >= b.raw_; }

  friend constexpr Fixed abs(Fixed a) { return Fixed(a.raw_ < 0 ? -a.raw_ : a.raw_, a.overflowed_); }

  /// A negative argument gives a flagged zero.
  friend constexpr Fixed sqrt(Fixed a) {
    if (a.raw_ < 0) return Fixed(0, true);
    // Digit by digit: the root of raw 2^FractionBits, whose bits are brought down in pairs.
    using Unsigned = std::make_unsigned_t<Raw>;
    const auto x = static_cast<Unsigned>(a.raw_);
    Unsigned remainder = 0;
    Unsigned root = 0;
    constexpr int pairs = (digits + FractionBits + 1) / 2;
    for (int pair = pairs - 1; pair >= 0; --pair) {
      const int place = 2 * pair - FractionBits;  // of the pair's lower bit in x
      Unsigned bits = 0;
      if (place >= 0) {
        bits = (x >> static_cast<unsigned>(place)) & 3U;
      } else if (place == -1) {
        bits = (x & 1U) << 1U;
      }
      remainder = (remainder << 2U) | bits;
      root <<= 1U;
      const Unsigned trial = (root << 1U) | 1U;
      if (remainder >= trial) {
        remainder -= trial;
        root |= 1U;
      }
    }
    if (remainder > root) ++root;  // x > root^2 + root: beyond (root + 1/2)^2
    return Fixed(static_cast<Raw>(root), a.overflowed_);
  }

 private:
  static constexpr Raw one = Raw{1} << FractionBits;
  static constexpr Raw most = std::numeric_limits<Raw>::max();  // -most at the other end
  static constexpr std::uint64_t low_half = 0xFFFFFFFFU;

  constexpr Fixed(Raw raw, bool overflowed) : raw_(raw), overflowed_(overflowed) {}

  /// Of any integer but the lowest of 64 bits.
  [[nodiscard]] static constexpr std::uint64_t magnitude_of(std::int64_t raw) {
    return static_cast<std::uint64_t>(raw < 0 ? -raw : raw);
  }
  [[nodiscard]] static constexpr Fixed from_magnitude(std::uint64_t magnitude, bool fits, bool negative, bool flagged) {
    if (!fits || (magnitude >> digits) != 0U) return Fixed(negative ? -most : most, true);
    const auto raw = static_cast<Raw>(magnitude);
    return Fixed(negative ? -raw : raw, flagged);
  }
  /// magnitude 2^shift, shift < 63.
  [[nodiscard]] static constexpr Fixed scaled_up(std::uint64_t magnitude, int shift, bool negative, bool flagged) {
    const bool fits = (magnitude >> (63 - shift)) == 0U;
    return from_magnitude(fits ? magnitude << shift : 0U, fits, negative, flagged);
  }

  Raw raw_ = 0;
  bool overflowed_ = false;
};

/// Q16.47, +-65536 in steps of 7.1e-15: what the solvers use.
using FixedQ47 = Fixed<47>;
/// Q7.56, +-128 in steps of 1.4e-17: where ranges are proven.
using FixedQ56 = Fixed<56>;
/// Q2.29 in 32 bits, +-4 in steps of 1.9e-9: attitudes.
using FixedQ29 = Fixed<29, std::int32_t>;

}  // namespace relnav

namespace Eigen {

template <int FractionBits, typename Raw>
struct NumTraits<relnav::Fixed<FractionBits, Raw>> : GenericNumTraits<relnav::Fixed<FractionBits, Raw>> {
  using Real = relnav::Fixed<FractionBits, Raw>;
  using NonInteger = Real;
  using Nested = Real;
  using Literal = Real;
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
  static constexpr Real epsilon() { return Real::from_raw(1); }
  static constexpr Real dummy_precision() { return Real::from_raw(16); }
  static constexpr Real highest() { return Real::from_raw(std::numeric_limits<Raw>::max()); }
  static constexpr Real lowest() { return -highest(); }
};

}  // namespace Eigen
