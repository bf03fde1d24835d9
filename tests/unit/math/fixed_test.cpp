// Fixed against exact integers: every operation of 64 and 32 bits to the last bit, saturation, and the flag.
#include "fsw/math/fixed.hpp"

#include <cmath>
#include <cstdio>
#include <initializer_list>
#include <limits>
#include <string>
#include <vector>

#include "fsw/base/generator.hpp"
#include "tests/support/campaign.hpp"
#include "tests/support/wide.hpp"

#include <CppUTest/TestHarness.h>

using namespace relnav;
using test::Wide;

namespace {

constexpr std::uint64_t seed = 161803;
constexpr int share = test::campaign(1, 10);  // of the samples
constexpr std::int64_t most = INT64_MAX;

Wide magnitude(std::int64_t raw) { return raw < 0 ? -Wide(raw) : Wide(raw); }

struct Expectation {
  std::int64_t raw = 0;
  bool overflowed = false;
};

/// Saturates at +- the largest Raw.
template <typename Raw = std::int64_t>
Expectation saturated(Wide value) {
  constexpr std::int64_t largest = std::numeric_limits<Raw>::max();
  if (value > largest) return {largest, true};
  if (value < -Wide(largest)) return {-largest, true};
  return {static_cast<std::int64_t>(value), false};
}

/// n / d for n >= 0, d > 0, halves away from zero, with the sign.
template <typename Raw>
Expectation rounded_quotient(Wide n, Wide d, bool negative) {
  const Wide whole = n / d;
  const Wide rest = n - whole * d;
  const Wide q = rest >= d - rest ? whole + 1 : whole;
  return saturated<Raw>(negative ? -q : q);
}

/// Of every size, both signs, and close to where something happens.
template <typename Raw>
class RawSamples {
  static constexpr int digits = std::numeric_limits<Raw>::digits;

 public:
  Raw draw() {
    if (generator_.below(8) == 0) return special_[generator_.below(static_cast<std::uint32_t>(special_.size()))];
    const std::uint64_t bits = (static_cast<std::uint64_t>(generator_.next()) << 32U) | generator_.next();
    const auto raw = static_cast<Raw>(bits >> (64U - digits + generator_.below(digits)));
    return generator_.below(2) == 0 ? raw : -raw;
  }

 private:
  static std::vector<Raw> boundary_values() {
    constexpr Raw largest = std::numeric_limits<Raw>::max();
    std::vector<Raw> values{0};
    for (int bit = 0; bit < digits; ++bit) {
      const Raw power = Raw{1} << bit;
      for (const Raw v : {power - 1, power, power + 1}) {
        values.push_back(v);
        values.push_back(-v);
      }
    }
    for (Raw k = 0; k < 3; ++k) {
      values.push_back(largest - k);
      values.push_back(k - largest);
    }
    return values;
  }
  std::vector<Raw> special_ = boundary_values();
  Generator generator_{seed};
};

template <int Bits, typename Raw>
void check(const Fixed<Bits, Raw>& actual, const Expectation& expected, const char* what, std::int64_t a = 0,
           std::int64_t b = 0) {
  if (actual.raw() == expected.raw && actual.overflowed() == expected.overflowed) return;
  const std::string message =
      std::string(what) + " of raw " + std::to_string(a) + ", " + std::to_string(b) + " with " + std::to_string(Bits) +
      " bits: " + std::to_string(actual.raw()) + ", expected " + std::to_string(expected.raw) +
      (actual.overflowed() == expected.overflowed ? "" : ", flag is wrong") + ", seed " + std::to_string(seed);
  FAIL(message.c_str());
}

template <int Bits, typename Raw = std::int64_t>
void check_arithmetic(int count) {
  using F = Fixed<Bits, Raw>;
  const Wide one = Wide(1) << Bits;
  RawSamples<Raw> samples;
  for (int i = 0; i < count / share; ++i) {
    const Raw a = samples.draw();
    const Raw b = samples.draw();
    const F x = F::from_raw(a);
    const F y = F::from_raw(b);
    const bool negative = (a < 0) != (b < 0);
    check(x + y, saturated<Raw>(Wide(a) + b), "sum", a, b);
    check(x - y, saturated<Raw>(Wide(a) - b), "difference", a, b);
    check(x * y, rounded_quotient<Raw>(magnitude(a) * magnitude(b), one, negative), "product", a, b);
    if (b != 0) check(x / y, rounded_quotient<Raw>(magnitude(a) * one, magnitude(b), negative), "quotient", a, b);
    check(-x, {-a, false}, "negative", a, b);
    check(abs(x), {static_cast<std::int64_t>(magnitude(a)), false}, "abs", a, b);
    CHECK((x < y) == (a < b) && (x > y) == (a > b) && (x <= y) == (a <= b) && (x >= y) == (a >= b) &&
          (x == y) == (a == b));
  }
}

template <int Bits, typename Raw = std::int64_t>
void check_roots(int count) {
  RawSamples<Raw> samples;
  for (int i = 0; i < count / share; ++i) {
    const Raw a = samples.draw();
    const Fixed<Bits, Raw> root = sqrt(Fixed<Bits, Raw>::from_raw(a));
    if (a < 0) {
      check(root, {0, true}, "root", a, 0);
      continue;
    }
    // r - 1/2 < root < r + 1/2, squared, times 4
    const Wide square = Wide(a) << Bits;
    const Wide r = root.raw();
    const bool nearest = (r == 0 || r * r - r < square) && square <= r * r + r;
    if (root.overflowed() || r < 0 || !nearest) {
      FAIL(("root of raw " + std::to_string(a) + ": " + std::to_string(root.raw())).c_str());
    }
  }
}

template <typename To, typename From>
void check_conversions(int to_bits, int from_bits, int count) {
  using ToRaw = decltype(To().raw());
  RawSamples<decltype(From().raw())> samples;
  for (int i = 0; i < count / share; ++i) {
    const auto a = samples.draw();
    const Expectation expected = to_bits >= from_bits
                                     ? saturated<ToRaw>(Wide(a) * (Wide(1) << (to_bits - from_bits)))
                                     : rounded_quotient<ToRaw>(magnitude(a), Wide(1) << (from_bits - to_bits), a < 0);
    check(To(From::from_raw(a)), expected, "conversion", a);
  }
  CHECK(To(From(1) / From(0)).overflowed());
}

}  // namespace

TEST_GROUP(FixedPoint){};

TEST(FixedPoint, sums_products_and_quotients_are_exact_to_the_last_bit) {
  check_arithmetic<47>(200000);
  check_arithmetic<1>(50000);
  check_arithmetic<30>(50000);
  check_arithmetic<56>(50000);
  check_arithmetic<61>(50000);
  check_arithmetic<29, std::int32_t>(200000);
  check_arithmetic<24, std::int32_t>(50000);
  check_arithmetic<1, std::int32_t>(50000);
}

TEST(FixedPoint, conversions_between_formats_are_the_nearest_or_saturate) {
  check_conversions<FixedQ56, FixedQ47>(56, 47, 50000);
  check_conversions<FixedQ47, FixedQ56>(47, 56, 50000);
  check_conversions<FixedQ29, FixedQ47>(29, 47, 50000);
  check_conversions<FixedQ47, FixedQ29>(47, 29, 50000);
  check_conversions<Fixed<24, std::int32_t>, FixedQ29>(24, 29, 50000);
  check_conversions<FixedQ29, Fixed<24, std::int32_t>>(29, 24, 50000);
  check_conversions<Fixed<1>, Fixed<61>>(1, 61, 50000);
  check_conversions<Fixed<61>, Fixed<1>>(61, 1, 50000);
}

TEST(FixedPoint, halves_are_rounded_away_from_zero) {
  const FixedQ47 half = FixedQ47::from_raw(std::int64_t{1} << 46);
  for (const std::int64_t raw : {1, 3, 5, 1001}) {
    const FixedQ47 x = FixedQ47::from_raw(raw);
    LONGS_EQUAL((raw + 1) / 2, (x * half).raw());
    LONGS_EQUAL(-(raw + 1) / 2, (x * -half).raw());
    LONGS_EQUAL((raw + 1) / 2, (x / FixedQ47(2)).raw());
    LONGS_EQUAL(-(raw + 1) / 2, (-x / FixedQ47(2)).raw());
  }
}

TEST(FixedPoint, what_is_too_large_saturates_with_a_flag) {
  const FixedQ47 largest = FixedQ47::from_raw(most);
  const FixedQ47 step = FixedQ47::from_raw(1);
  check(largest + step, {most, true}, "largest + step");
  check(-largest - step, {-most, true}, "-largest - step");
  check(FixedQ47(256) * FixedQ47(256), {most, true}, "65536");
  check(FixedQ47(-256) * FixedQ47(256), {-most, true}, "-65536");
  check(largest / FixedQ47(0.5), {most, true}, "2 largest");
  check(FixedQ47(-1) / step, {-most, true}, "-1 / step");
  CHECK_FALSE((FixedQ47(256) * FixedQ47(255)).overflowed());
}

TEST(FixedPoint, the_lowest_integer_is_out_of_range) {
  check(FixedQ47::from_raw(INT64_MIN), {-most, true}, "lowest of 64 bits");
  check(FixedQ29::from_raw(INT32_MIN), {-INT32_MAX, true}, "lowest of 32 bits");
}

TEST(FixedPoint, division_by_zero_saturates_toward_the_sign_of_the_numerator) {
  check(FixedQ47(3) / FixedQ47(0), {most, true}, "3 / 0");
  check(FixedQ47(-3) / FixedQ47(0), {-most, true}, "-3 / 0");
  CHECK((FixedQ47(0) / FixedQ47(0)).overflowed());
}

TEST(FixedPoint, roots_are_the_nearest_and_negative_ones_flagged) {
  check_roots<47>(200000);
  check_roots<1>(50000);
  check_roots<30>(50000);
  check_roots<61>(50000);
  check_roots<29, std::int32_t>(50000);
  check_roots<1, std::int32_t>(50000);
  CHECK(sqrt(FixedQ47(9)) == FixedQ47(3));
  CHECK(sqrt(FixedQ47(0)) == FixedQ47(0));
}

TEST(FixedPoint, the_flag_is_carried_through_everything) {
  int zero = 0;  // no constant: the compiler would do all of it
  const FixedQ47 bad = FixedQ47(1) / FixedQ47(zero);
  const FixedQ47 good(0.25);
  for (const FixedQ47& x : {bad - bad, bad * FixedQ47(0), FixedQ47(0) * bad, bad + good, good + bad, good - bad, -bad,
                            good / bad, bad / good, abs(bad), sqrt(bad)}) {
    CHECK(x.overflowed());
  }
  FixedQ47 sum = good;
  sum += good;
  sum -= good;
  sum *= good;
  sum /= good;
  CHECK_FALSE(sum.overflowed());
  CHECK(sum == good);
  sum += bad;
  sum -= bad;
  CHECK(sum.overflowed());
  sum = good;
  CHECK_FALSE(sum.overflowed());
}

TEST(FixedPoint, from_int_is_exact_or_saturates) {
  for (const int value :
       std::initializer_list<int>{0, 1, -1, 2, 1000, -1000, 65535, -65535, 65536, -65536, INT32_MAX, INT32_MIN}) {
    check(FixedQ47(value), saturated(Wide(value) * (Wide(1) << 47)), "number", value);
    check(Fixed<1>(value), saturated(Wide(value) * 2), "number", value);
    check(FixedQ29(value), saturated<std::int32_t>(Wide(value) * (Wide(1) << 29)), "number", value);
    check(Fixed<61>(value), saturated(Wide(value) * (Wide(1) << 61)), "number", value);
  }
}

TEST(FixedPoint, from_double_is_the_nearest) {
  Generator generator(seed);
  for (int i = 0; i < 300000 / share; ++i) {
    // Raw numbers of every size, with and without bits below the last place.
    const double unit = 2.0 * (generator.uniform() + 0x1p-32 * generator.uniform()) - 1.0;
    double value = std::ldexp(unit, static_cast<int>(generator.below(66)) - 48);
    if (generator.below(4) == 0) value = std::ldexp(std::floor(std::ldexp(value, 48)), -48);  // halves
    if (!(std::fabs(value) < 65535.9)) continue;
    const double expected = std::round(std::ldexp(value, 47));  // exact, both
    check(FixedQ47(value), {static_cast<std::int64_t>(expected), false}, "number near",
          static_cast<std::int64_t>(value));
  }
  // Odd where a double has no halves left.
  check(FixedQ47(0x1p5 + 0x1p-47), {(std::int64_t{1} << 52) + 1, false}, "2^52 + 1 steps");
  check(FixedQ47(-0x1p5 - 0x1p-47), {-(std::int64_t{1} << 52) - 1, false}, "-2^52 - 1 steps");
  check(FixedQ47(0x1p-48 - 0x1p-101), {0, false}, "just under half a step");
  // 32 bits: halves up to the end of the range.
  for (const std::int64_t raw : {std::int64_t{0}, std::int64_t{7}, std::int64_t{INT32_MAX - 1}}) {
    const double value = std::ldexp(static_cast<double>(raw), -29);
    check(FixedQ29(value + 0x1p-30), {raw + 1, false}, "and a half", raw);
    check(FixedQ29(-value - 0x1p-30), {-raw - 1, false}, "and a half, negative", raw);
    check(FixedQ29(value + 0x1p-31), {raw, false}, "and a quarter", raw);
  }
}

TEST(FixedPoint, from_double_saturates_and_flags_what_is_no_number) {
  check(FixedQ47(65536.0), {most, true}, "65536");
  check(FixedQ47(-65536.0), {-most, true}, "-65536");
  check(FixedQ47(1e300), {most, true}, "1e300");
  check(FixedQ47(HUGE_VAL), {most, true}, "infinity");
  check(FixedQ47(-HUGE_VAL), {-most, true}, "-infinity");
  check(FixedQ47(std::nan("")), {0, true}, "NaN");
  check(FixedQ29(4.0), {INT32_MAX, true}, "4");
  check(FixedQ29(-4.0), {-INT32_MAX, true}, "-4");
  check(FixedQ29(4.0 - 0x1p-29), {INT32_MAX, false}, "the largest of 32 bits");
  const double largest = std::nextafter(65536.0, 0.0);
  CHECK_FALSE(FixedQ47(largest).overflowed());
  CHECK(static_cast<double>(FixedQ47(largest)) == largest);
}

TEST(FixedPoint, to_double_and_back) {
  Generator generator(seed + 1);
  for (int i = 0; i < 10000; ++i) {
    // 53 bits at most: exact both ways.
    const auto raw =
        static_cast<std::int64_t>((static_cast<std::uint64_t>(generator.next()) << 21U) >> generator.below(50)) *
        (generator.below(2) == 0 ? 1 : -1);
    const FixedQ47 x = FixedQ47::from_raw(raw);
    CHECK(static_cast<double>(x) == std::ldexp(static_cast<double>(raw), -47));
    CHECK(FixedQ47(static_cast<double>(x)).raw() == raw);
  }
}
