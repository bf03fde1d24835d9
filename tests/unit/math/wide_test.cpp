// The reference of the fixed-point tests (tests/support/wide.hpp): against the compiler's 128 bits where it has them, and by
// laws of integers everywhere.
#include "tests/support/wide.hpp"

#include <cmath>

#include "fsw/base/generator.hpp"

#include <CppUTest/TestHarness.h>

using namespace relnav;
using test::Wide;

namespace {

std::int64_t draw(Generator& generator) {
  const std::uint64_t bits = (static_cast<std::uint64_t>(generator.next()) << 32U) | generator.next();
  const auto value = static_cast<std::int64_t>(bits >> (1U + generator.below(63)));
  return generator.below(2) == 0 ? value : -value;
}

}  // namespace

TEST_GROUP(Wide){};

TEST(Wide, keeps_the_laws_of_integers) {
  Generator generator(314159);
  for (int i = 0; i < 20000; ++i) {
    const Wide a = draw(generator);
    const Wide b = draw(generator);
    const Wide c = Wide(draw(generator)) << 20;
    CHECK(a + b - b == a && -(-a) == a);
    CHECK((a + b) * (a - b) == a * a - b * b);
    CHECK(a * b == b * a && a * (b + c) == a * b + a * c);
    CHECK((a < b) == (a - b < 0) && (a < b) == (-b < -a));
    CHECK((a << 37) == a * (Wide(1) << 37));
    const Wide n = a * a;
    const Wide d = b < 0 ? -b : b + 1;
    const Wide rest = n - n / d * d;
    CHECK(rest >= 0 && rest < d);
  }
}

TEST(Wide, to_double_is_the_nearest_and_back_exact) {
  CHECK(static_cast<double>(Wide(1) << 126) == 0x1p126);
  CHECK(static_cast<double>(-(Wide(1) << 100)) == -0x1p100);
  // Half a step at 2^100 is 2^47: to even, unless anything is behind it.
  const Wide large = Wide(1) << 100;
  const Wide half = Wide(1) << 47;
  CHECK(static_cast<double>(large + half) == 0x1p100);
  CHECK(static_cast<double>(large + half + 1) == 0x1.0000000000001p100);
  CHECK(static_cast<double>(large + (half << 1) + half) == 0x1.0000000000002p100);
  for (const double value :
       {0.0, 1.0, -1.0, 0x1.fffffffffffffp62, -0x1p63, 0x1.23456789abcdep99, -0x1.23456789abcdep99})
    CHECK(static_cast<double>(Wide::from_double(value)) == value);
}

#ifdef __SIZEOF_INT128__
TEST(Wide, is_as_the_compilers_integer) {
  __extension__ using Builtin = __int128;
  const auto same = [](Wide a, Builtin b) {
    return static_cast<std::int64_t>(a) == static_cast<std::int64_t>(b) &&
           static_cast<double>(a) == static_cast<double>(b) && (a < 0) == (b < 0);
  };
  Generator generator(271828);
  for (int i = 0; i < 100000; ++i) {
    const std::int64_t a = draw(generator);
    const std::int64_t b = draw(generator);
    const int bits = static_cast<int>(generator.below(64));
    const Builtin p = static_cast<Builtin>(a) * b;
    const Builtin magnitude = p < 0 ? -p : p;
    CHECK(same(Wide(a) * b, p));
    CHECK(same(Wide(a) + b, static_cast<Builtin>(a) + b));
    CHECK(same(Wide(a) - Wide(b) * b, a - static_cast<Builtin>(b) * b));
    CHECK(same(Wide(a) << bits, static_cast<Builtin>(a) * (static_cast<Builtin>(1) << bits)));
    if (a > 0) CHECK(same((p < 0 ? -(Wide(a) * b) : Wide(a) * b) / a, magnitude / a));
    if (b != 0 && a > 0)
      CHECK(same((Wide(a) << bits) / (b < 0 ? -Wide(b) : Wide(b)),
                 (static_cast<Builtin>(a) << bits) / (b < 0 ? -static_cast<Builtin>(b) : b)));
  }
}
#endif
