#include <cfloat>
#include <cmath>
#include <cstdio>
#include <limits>
#include <string>

#include "fsw/base/generator.hpp"
#include "fsw/math/elementary.hpp"
#include "tests/support/campaign.hpp"
#include "tests/unit/math/bits.hpp"

#include <CppUTest/TestHarness.h>

using namespace relnav;
using test::same_bits;

namespace {

constexpr std::uint64_t seed = 314159;
constexpr double quiet_nan = std::numeric_limits<double>::quiet_NaN();
constexpr double unbounded = std::numeric_limits<double>::infinity();
constexpr double smallest = std::numeric_limits<double>::denorm_min();
constexpr double pi = 3.14159265358979311600;

using Real = long double;
// The error bounds need a reference with more digits than double.
constexpr bool have_reference = LDBL_MANT_DIG >= 64;

/// Uniform on [0, 1), with a full significand.
double draw(Generator& generator) {
  const double high = generator.uniform();
  return high + 0x1p-32 * generator.uniform();
}

Real ulp(double x) {
  const double size = std::abs(x);
  if (size < DBL_MIN) return std::ldexp(Real{1}, -1074);
  int exponent = 0;
  static_cast<void>(std::frexp(size, &exponent));
  return std::ldexp(Real{1}, exponent - 53);
}
Real error_in_ulp(double value, Real reference) {
  const auto rounded = static_cast<double>(reference);
  if (std::isinf(rounded))
    return std::isinf(value) && std::signbit(value) == std::signbit(rounded) ? Real{0} : Real{1e9L};
  return std::abs(static_cast<Real>(value) - reference) / static_cast<Real>(ulp(rounded));
}

/// Largest error seen and where.
struct Worst {
  Real error = 0;
  double at = 0;
  double at2 = 0;
  void add(Real e, double x, double x2 = 0) {
    if (!(e <= error)) {
      error = e;
      at = x;
      at2 = x2;
    }
  }
};

void check_bound(const char* name, const Worst& worst, double bound) {
  char text[160];
  std::snprintf(text, sizeof(text), "%s: %.4f ulp at %a, %a (seed %llu)", name, static_cast<double>(worst.error),
                worst.at, worst.at2, static_cast<unsigned long long>(seed));
  std::printf("\n  %s", text);
  CHECK_TEXT(worst.error <= static_cast<Real>(bound), text);
}

template <typename F, typename R>
void sweep(Worst& worst, F function, R reference, double from, double to, int count) {
  Generator generator(seed);
  for (int i = 0; i < count; ++i) {
    // an even grid, jittered, with both ends
    const double fraction = i + 1 == count ? 1.0 : (static_cast<double>(i) + (i == 0 ? 0.0 : draw(generator))) / count;
    const double x = from + (to - from) * fraction;
    worst.add(error_in_ulp(function(x), reference(static_cast<Real>(x))), x);
  }
}
/// 2^from .. 2^to, both signs.
template <typename F, typename R>
void sweep_exponents(Worst& worst, F function, R reference, int from, int to, int each, bool negative_too) {
  Generator generator(seed);
  for (int e = from; e < to; ++e) {
    for (int i = 0; i < each; ++i) {
      double x = std::ldexp(1.0 + draw(generator), e);
      if (negative_too && (i & 1) == 1) x = -x;
      worst.add(error_in_ulp(function(x), reference(static_cast<Real>(x))), x);
    }
  }
}
/// The neighbours of each multiple of `step` up to `limit`.
template <typename F, typename R>
void sweep_neighbours(Worst& worst, F function, R reference, Real step, double limit) {
  for (int k = 1; static_cast<double>(k * step) < limit; k = k < 1000 ? k + 1 : k + k / 700) {
    double x = static_cast<double>(k * step);
    for (int i = 0; i < 3; ++i) x = std::nextafter(x, 0.0);
    for (int i = 0; i < 6; ++i) {
      worst.add(error_in_ulp(function(x), reference(static_cast<Real>(x))), x);
      x = std::nextafter(x, unbounded);
    }
  }
}

constexpr int dense_count = test::campaign(200000, 20000);  // long double is software on most targets
Real sin_ref(Real x) { return std::sin(x); }
Real cos_ref(Real x) { return std::cos(x); }
Real tan_ref(Real x) { return std::tan(x); }
Real atan_ref(Real x) { return std::atan(x); }
Real asin_ref(Real x) { return std::asin(x); }
Real acos_ref(Real x) { return std::acos(x); }
Real exp_ref(Real x) { return std::exp(x); }
Real log_ref(Real x) { return std::log(x); }

template <typename F, typename R>
Worst circular(F function, R reference) {
  Worst worst;
  sweep(worst, function, reference, -0.8, 0.8, dense_count);
  sweep(worst, function, reference, -7.0, 7.0, dense_count);
  sweep(worst, function, reference, -1e5, 1e5, dense_count);
  sweep(worst, function, reference, -math::max_angle, math::max_angle, dense_count);
  sweep_exponents(worst, function, reference, -1074, 20, 50, true);
  sweep_neighbours(worst, function, reference, 0.785398163397448309615660845819875721L, math::max_angle);
  return worst;
}

}  // namespace

TEST_GROUP(Elementary){};

TEST(Elementary, sin_and_cos_within_one_ulp) {
  if (!have_reference) return;
  check_bound("sin", circular(math::sin, sin_ref), 1.0);
  check_bound("cos", circular(math::cos, cos_ref), 1.0);
}

TEST(Elementary, tan_within_two_ulp) {
  if (!have_reference) return;
  check_bound("tan", circular(math::tan, tan_ref), 2.0);
}

// The double nearest to each multiple of pi/2: up to 66 leading bits cancel there.
TEST(Elementary, reduction_keeps_its_digits_next_to_multiples_of_half_pi) {
  if (!have_reference) return;
  Worst worst;
  for (int k = 1; k < 667544; ++k) {
    const auto x = static_cast<double>(static_cast<Real>(k) * 1.57079632679489661923132169163975144L);
    if (std::abs(math::sin(x)) < 1e-13 || std::abs(math::cos(x)) < 1e-13) {
      worst.add(error_in_ulp(math::sin(x), sin_ref(static_cast<Real>(x))), x);
      worst.add(error_in_ulp(math::cos(x), cos_ref(static_cast<Real>(x))), x);
    }
  }
  check_bound("sin, cos next to k pi/2", worst, 1.0);
}

TEST(Elementary, atan_within_one_ulp) {
  if (!have_reference) return;
  Worst worst;
  sweep(worst, math::atan, atan_ref, -1.0, 1.0, dense_count);
  sweep(worst, math::atan, atan_ref, -6.0, 6.0, dense_count);
  sweep_exponents(worst, math::atan, atan_ref, -1074, 1024, 50, true);
  for (const double edge : {0.4, 0.5, 0.75, 1.0, 1.25, 1.75, 2.5, 0x1p-28})
    sweep_neighbours(worst, math::atan, atan_ref, static_cast<Real>(edge), 1.5 * edge);
  check_bound("atan", worst, 1.0);
}

TEST(Elementary, atan2_within_two_ulp) {
  if (!have_reference) return;
  Worst worst;
  Generator generator(seed);
  for (int i = 0; i < 600000; ++i) {
    const int scale =
        i % 3 == 0 ? static_cast<int>(generator.below(80)) - 40 : static_cast<int>(generator.below(9)) - 4;
    const double y = std::ldexp(2.0 * draw(generator) - 1.0, scale);
    const double x = 2.0 * draw(generator) - 1.0;
    worst.add(error_in_ulp(math::atan2(y, x), std::atan2(static_cast<Real>(y), static_cast<Real>(x))), y, x);
  }
  for (int e = -1074; e < 1024; e += 3) {
    for (int f = -1074; f < 1024; f += 97) {
      for (const double s : {1.25, -1.25}) {
        const double y = std::ldexp(1.0 + draw(generator), e);
        const double x = std::ldexp(s, f);
        worst.add(error_in_ulp(math::atan2(y, x), std::atan2(static_cast<Real>(y), static_cast<Real>(x))), y, x);
      }
    }
  }
  check_bound("atan2", worst, 2.0);
}

TEST(Elementary, asin_and_acos_within_two_ulp) {
  if (!have_reference) return;
  Worst s;
  Worst c;
  sweep(s, math::asin, asin_ref, -1.0, 1.0, 2 * dense_count);
  sweep(c, math::acos, acos_ref, -1.0, 1.0, 2 * dense_count);
  sweep_exponents(s, math::asin, asin_ref, -1074, 0, 50, true);
  sweep_exponents(c, math::acos, acos_ref, -1074, 0, 50, true);
  for (double gap = 0x1p-53; gap < 0.5; gap *= 1.01) {
    for (const double x : {1.0 - gap, gap - 1.0}) {
      s.add(error_in_ulp(math::asin(x), asin_ref(static_cast<Real>(x))), x);
      c.add(error_in_ulp(math::acos(x), acos_ref(static_cast<Real>(x))), x);
    }
  }
  sweep_neighbours(s, math::asin, asin_ref, 0.5L, 0.75);
  sweep_neighbours(c, math::acos, acos_ref, 0.5L, 0.75);
  check_bound("asin", s, 2.0);
  check_bound("acos", c, 2.0);
}

TEST(Elementary, exp_within_one_ulp) {
  if (!have_reference) return;
  Worst worst;
  sweep(worst, math::exp, exp_ref, -1.0, 1.0, dense_count);
  sweep(worst, math::exp, exp_ref, -708.0, 709.78271289338397, dense_count);
  sweep(worst, math::exp, exp_ref, -745.2, -707.0, dense_count);
  sweep_exponents(worst, math::exp, exp_ref, -1074, 9, 50, true);
  sweep_neighbours(worst, math::exp, exp_ref, 0.346573590279972654708616060729088284L, 709.0);
  check_bound("exp", worst, 1.0);
}

TEST(Elementary, log_within_one_ulp) {
  if (!have_reference) return;
  Worst worst;
  sweep(worst, math::log, log_ref, 0.5, 2.0, 2 * dense_count);
  sweep(worst, math::log, log_ref, 0.999, 1.001, dense_count);
  sweep_exponents(worst, math::log, log_ref, -1074, 1024, 100, false);
  sweep_neighbours(worst, math::log, log_ref, 1.41421356237309504880168872420969808L, 2.0);
  sweep_neighbours(worst, math::log, log_ref, 1.0L, 1.5);
  check_bound("log", worst, 1.0);
}

TEST(Elementary, odd_functions_keep_signed_zero_and_tiny_arguments) {
  for (const double x : {0.0, smallest, 1e-310, DBL_MIN, 0x1p-60}) {
    for (const double s : {x, -x}) {
      CHECK(same_bits(s, math::sin(s)));
      CHECK(same_bits(s, math::tan(s)));
      CHECK(same_bits(s, math::atan(s)));
      CHECK(same_bits(s, math::asin(s)));
      CHECK(same_bits(1.0, math::cos(s)));
      CHECK(same_bits(1.0, math::exp(s)));
    }
  }
}

TEST(Elementary, outside_the_domain_is_nan) {
  for (const double x :
       {quiet_nan, unbounded, -unbounded, std::nextafter(math::max_angle, unbounded), -2.0 * math::max_angle, 1e300}) {
    CHECK(std::isnan(math::sin(x)));
    CHECK(std::isnan(math::cos(x)));
    CHECK(std::isnan(math::tan(x)));
    CHECK(std::isnan(math::sincos(x).sin));
    CHECK(std::isnan(math::sincos(x).cos));
  }
  CHECK(!std::isnan(math::sin(math::max_angle)));
  CHECK(!std::isnan(math::tan(-math::max_angle)));
  for (const double x : {quiet_nan, unbounded, -unbounded, std::nextafter(1.0, 2.0), std::nextafter(-1.0, -2.0)}) {
    CHECK(std::isnan(math::asin(x)));
    CHECK(std::isnan(math::acos(x)));
  }
  CHECK(std::isnan(math::atan(quiet_nan)));
  CHECK(std::isnan(math::atan2(quiet_nan, 1.0)));
  CHECK(std::isnan(math::atan2(1.0, quiet_nan)));
  CHECK(std::isnan(math::exp(quiet_nan)));
  CHECK(std::isnan(math::log(quiet_nan)));
  CHECK(std::isnan(math::log(-smallest)));
  CHECK(std::isnan(math::log(-unbounded)));
}

TEST(Elementary, limits) {
  CHECK(same_bits(pi / 2, math::atan(unbounded)));
  CHECK(same_bits(-pi / 2, math::atan(-unbounded)));
  CHECK(same_bits(pi / 2, math::asin(1.0)));
  CHECK(same_bits(-pi / 2, math::asin(-1.0)));
  CHECK(same_bits(0.0, math::acos(1.0)));
  CHECK(same_bits(pi, math::acos(-1.0)));
  CHECK(same_bits(pi / 2, math::acos(0.0)));
  CHECK(same_bits(pi / 2, math::acos(-0.0)));
  CHECK(same_bits(unbounded, math::exp(unbounded)));
  CHECK(same_bits(0.0, math::exp(-unbounded)));
  CHECK(same_bits(unbounded, math::exp(709.79)));
  CHECK(math::exp(709.78) < unbounded);
  CHECK(same_bits(0.0, math::exp(-745.14)));
  CHECK(same_bits(smallest, math::exp(-745.13)));
  CHECK(same_bits(0.0, math::log(1.0)));
  CHECK(same_bits(unbounded, math::log(unbounded)));
  CHECK(same_bits(-unbounded, math::log(0.0)));
  CHECK(same_bits(-unbounded, math::log(-0.0)));
}

TEST(Elementary, quadrants_zeros_and_infinities_of_atan2) {
  struct Case {
    double y, x, angle;
  };
  const Case cases[] = {
      {0.0, 1.0, 0.0},
      {0.0, 0.0, 0.0},
      {0.0, -1.0, pi},
      {0.0, -0.0, pi},
      {1.0, 0.0, pi / 2},
      {1.0, -0.0, pi / 2},
      {1.0, 1.0, pi / 4},
      {1.0, -1.0, 3 * pi / 4},
      {unbounded, 1.0, pi / 2},
      {unbounded, -1.0, pi / 2},
      {1.0, unbounded, 0.0},
      {1.0, -unbounded, pi},
      {0.0, unbounded, 0.0},
      {0.0, -unbounded, pi},
      {unbounded, unbounded, pi / 4},
      {unbounded, -unbounded, 3 * pi / 4},
      {smallest, 1.0, smallest},
      {smallest, -1.0, pi},
      {1e300, 1e-300, pi / 2},
      {1e-300, 1e300, 0.0},
      {1e-300, -1e300, pi},
      {smallest, smallest, pi / 4},
  };
  for (const Case& c : cases) {
    char text[96];
    std::snprintf(text, sizeof(text), "atan2(%g, %g) = %a", c.y, c.x, math::atan2(c.y, c.x));
    CHECK_TEXT(same_bits(c.angle, math::atan2(c.y, c.x)), text);
    CHECK_TEXT(same_bits(-c.angle, math::atan2(-c.y, c.x)), text);
  }
}

TEST(Elementary, symmetries_hold_bit_for_bit) {
  Generator generator(seed);
  for (int i = 0; i < 20000; ++i) {
    const int size = static_cast<int>(generator.below(18));
    const double x = std::ldexp(2.0 * draw(generator) - 1.0, size);
    CHECK(same_bits(-math::sin(x), math::sin(-x)));
    CHECK(same_bits(math::cos(x), math::cos(-x)));
    CHECK(same_bits(-math::tan(x), math::tan(-x)));
    CHECK(same_bits(-math::atan(x), math::atan(-x)));
    CHECK(same_bits(math::sin(x), math::sincos(x).sin));
    CHECK(same_bits(math::cos(x), math::sincos(x).cos));
  }
}

// These bits must come out on every target, compiler and optimisation level.
TEST(Elementary, golden_bits) {
  Generator generator(seed);
  test::BitHash hash;
  for (int i = 0; i < 20000; ++i) {
    const double unit = 2.0 * draw(generator) - 1.0;
    const double angle = unit * (i % 4 == 0 ? 1e6 : 10.0);
    const double other = 2.0 * draw(generator) - 1.0;
    hash.add(math::sin(angle));
    hash.add(math::cos(angle));
    hash.add(math::tan(angle));
    hash.add(math::atan(angle));
    hash.add(math::atan2(unit, other));
    hash.add(math::asin(unit));
    hash.add(math::acos(unit));
    hash.add(math::exp(700.0 * unit));
    hash.add(math::log(10.0 + angle + 1e6));
    hash.add(math::log(1.0 + 0.5 * unit));
  }
  char text[32];
  std::snprintf(text, sizeof(text), "%016llx", static_cast<unsigned long long>(hash.value()));
  STRCMP_EQUAL("e88ff39dca458cb3", text);
}
