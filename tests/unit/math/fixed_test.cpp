// Fixed against integers of 128 bits and long double: every operation to the last bit, saturation, and the flag.
#include "fsw/math/fixed.hpp"

#include <cfloat>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "fsw/base/generator.hpp"

#include <CppUTest/TestHarness.h>

using namespace relnav;

namespace {

constexpr std::uint64_t seed = 161803;
constexpr std::int64_t most = INT64_MAX;
__extension__ using Wide = __int128;

Wide magnitude(std::int64_t raw) { return raw < 0 ? -static_cast<Wide>(raw) : static_cast<Wide>(raw); }

struct Expectation {
  std::int64_t raw = 0;
  bool overflowed = false;
};

/// Saturates at +-most.
Expectation saturated(Wide value) {
  if (value > most) return {most, true};
  if (value < -static_cast<Wide>(most)) return {-most, true};
  return {static_cast<std::int64_t>(value), false};
}

/// n / d for n >= 0, d > 0, halves away from zero, with the sign.
Expectation rounded_quotient(Wide n, Wide d, bool negative) {
  const Wide q = n / d + (n % d >= d - n % d ? 1 : 0);
  return saturated(negative ? -q : q);
}

/// Of every size, both signs, and close to where something happens.
class RawSamples {
 public:
  std::int64_t draw() {
    if (generator_.below(8) == 0) return special_[generator_.below(static_cast<std::uint32_t>(special_.size()))];
    const std::uint64_t bits = (static_cast<std::uint64_t>(generator_.next()) << 32U) | generator_.next();
    const auto raw = static_cast<std::int64_t>(bits >> (1U + generator_.below(63)));
    return generator_.below(2) == 0 ? raw : -raw;
  }

 private:
  static std::vector<std::int64_t> boundary_values() {
    std::vector<std::int64_t> values{0};
    for (int bit = 0; bit < 63; ++bit) {
      const std::int64_t power = std::int64_t{1} << bit;
      for (const std::int64_t v : {power - 1, power, power + 1}) {
        values.push_back(v);
        values.push_back(-v);
      }
    }
    for (std::int64_t k = 0; k < 3; ++k) {
      values.push_back(most - k);
      values.push_back(k - most);
    }
    return values;
  }
  std::vector<std::int64_t> special_ = boundary_values();
  Generator generator_{seed};
};

template <int Bits>
void check(const Fixed<Bits>& actual, const Expectation& expected, const char* what, std::int64_t a = 0,
           std::int64_t b = 0) {
  if (actual.raw() == expected.raw && actual.overflowed() == expected.overflowed) return;
  const std::string message =
      std::string(what) + " of raw " + std::to_string(a) + ", " + std::to_string(b) + " with " + std::to_string(Bits) +
      " bits: " + std::to_string(actual.raw()) + ", expected " + std::to_string(expected.raw) +
      (actual.overflowed() == expected.overflowed ? "" : ", flag is wrong") + ", seed " + std::to_string(seed);
  FAIL(message.c_str());
}

template <int Bits>
void check_arithmetic(int count) {
  using F = Fixed<Bits>;
  const Wide one = Wide{1} << Bits;
  RawSamples samples;
  for (int i = 0; i < count; ++i) {
    const std::int64_t a = samples.draw();
    const std::int64_t b = samples.draw();
    const F x = F::from_raw(a);
    const F y = F::from_raw(b);
    const bool negative = (a < 0) != (b < 0);
    check(x + y, saturated(static_cast<Wide>(a) + b), "sum", a, b);
    check(x - y, saturated(static_cast<Wide>(a) - b), "difference", a, b);
    check(x * y, rounded_quotient(magnitude(a) * magnitude(b), one, negative), "product", a, b);
    if (b != 0) check(x / y, rounded_quotient(magnitude(a) * one, magnitude(b), negative), "quotient", a, b);
    check(-x, {-a, false}, "negative", a, b);
    check(abs(x), {static_cast<std::int64_t>(magnitude(a)), false}, "abs", a, b);
    CHECK((x < y) == (a < b) && (x > y) == (a > b) && (x <= y) == (a <= b) && (x >= y) == (a >= b) &&
          (x == y) == (a == b));
  }
}

template <int Bits>
void check_roots(int count) {
  RawSamples samples;
  for (int i = 0; i < count; ++i) {
    const std::int64_t a = samples.draw();
    const Fixed<Bits> root = sqrt(Fixed<Bits>::from_raw(a));
    if (a < 0) {
      check(root, {0, true}, "root", a, 0);
      continue;
    }
    const Wide square = static_cast<Wide>(a) << Bits;
    const Wide r = root.raw();
    if (root.overflowed() || r < 0 || r * r > square || (r + 1) * (r + 1) <= square) {
      FAIL(("root of raw " + std::to_string(a) + ": " + std::to_string(root.raw())).c_str());
    }
  }
}

}  // namespace

TEST_GROUP(FixedPoint){};

TEST(FixedPoint, sums_products_and_quotients_are_exact_to_the_last_bit) {
  check_arithmetic<47>(200000);
  check_arithmetic<1>(50000);
  check_arithmetic<30>(50000);
  check_arithmetic<61>(50000);
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

TEST(FixedPoint, division_by_zero_saturates_toward_the_sign_of_the_numerator) {
  check(FixedQ47(3) / FixedQ47(0), {most, true}, "3 / 0");
  check(FixedQ47(-3) / FixedQ47(0), {-most, true}, "-3 / 0");
  CHECK((FixedQ47(0) / FixedQ47(0)).overflowed());
}

TEST(FixedPoint, roots_are_rounded_down_and_negative_ones_flagged) {
  check_roots<47>(200000);
  check_roots<1>(50000);
  check_roots<30>(50000);
  check_roots<61>(50000);
  CHECK(sqrt(FixedQ47(9)) == FixedQ47(3));
  CHECK(sqrt(FixedQ47(0)) == FixedQ47(0));
}

TEST(FixedPoint, the_flag_is_carried_through_everything) {
  const FixedQ47 bad = FixedQ47(1) / FixedQ47(0);
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
  for (const int value : {0, 1, -1, 2, 1000, -1000, 65535, -65535, 65536, -65536, INT32_MAX, INT32_MIN}) {
    check(FixedQ47(value), saturated(static_cast<Wide>(value) * (Wide{1} << 47)), "number", value);
    check(Fixed<1>(value), saturated(static_cast<Wide>(value) * 2), "number", value);
    check(Fixed<61>(value), saturated(static_cast<Wide>(value) * (Wide{1} << 61)), "number", value);
  }
}

TEST(FixedPoint, from_double_is_the_nearest) {
  if (LDBL_MANT_DIG < 64) return;  // no reference
  Generator generator(seed);
  for (int i = 0; i < 300000; ++i) {
    // Raw numbers of every size, with and without bits below the last place.
    const double unit = 2.0 * (generator.uniform() + 0x1p-32 * generator.uniform()) - 1.0;
    double value = std::ldexp(unit, static_cast<int>(generator.below(66)) - 48);
    if (generator.below(4) == 0) value = std::ldexp(std::floor(std::ldexp(value, 48)), -48);  // halves
    if (!(std::fabs(value) < 65535.9)) continue;
    const long double expected = std::round(std::ldexp(static_cast<long double>(value), 47));
    check(FixedQ47(value), {static_cast<std::int64_t>(expected), false}, "number near",
          static_cast<std::int64_t>(value));
  }
  // Odd where a double has no halves left.
  check(FixedQ47(0x1p5 + 0x1p-47), {(std::int64_t{1} << 52) + 1, false}, "2^52 + 1 steps");
  check(FixedQ47(-0x1p5 - 0x1p-47), {-(std::int64_t{1} << 52) - 1, false}, "-2^52 - 1 steps");
  check(FixedQ47(0x1p-48 - 0x1p-101), {0, false}, "just under half a step");
}

TEST(FixedPoint, from_double_saturates_and_flags_what_is_no_number) {
  check(FixedQ47(65536.0), {most, true}, "65536");
  check(FixedQ47(-65536.0), {-most, true}, "-65536");
  check(FixedQ47(1e300), {most, true}, "1e300");
  check(FixedQ47(HUGE_VAL), {most, true}, "infinity");
  check(FixedQ47(-HUGE_VAL), {-most, true}, "-infinity");
  check(FixedQ47(std::nan("")), {0, true}, "NaN");
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
