// Pair: each lane is what the scalar gives, bit for bit, in every scalar.
#include "fsw/math/pair.hpp"

#include "fsw/base/generator.hpp"
#include "fsw/math/fixed.hpp"
#include "tests/unit/math/bits.hpp"

#include <CppUTest/TestHarness.h>

namespace relnav {
namespace {

bool same(double a, double b) { return test::same_bits(a, b); }
bool same(float a, float b) { return same(static_cast<double>(a), static_cast<double>(b)); }
bool same(FixedQ47 a, FixedQ47 b) { return a.raw() == b.raw() && a.overflowed() == b.overflowed(); }

template <typename S>
void check(const Pair<S>& p, const S& first, const S& second) {
  CHECK(same(p.first(), first));
  CHECK(same(p.second(), second));
}

template <typename S>
void check_operations() {
  Generator generator(3);
  const auto number = [&] { return S(100.0 * (generator.uniform() - 0.5)); };
  for (int i = 0; i < 1000; ++i) {
    const S a = number(), b = number(), c = number(), d = number();
    const Pair<S> ab(a, b), cd(c, d);
    check(ab, a, b);
    check(ab + cd, S(a + c), S(b + d));
    check(ab - cd, S(a - c), S(b - d));
    check(ab * cd, S(a * c), S(b * d));
    check(ab * c, S(a * c), S(b * c));
    Pair<S> sum = ab;
    sum += cd * cd;
    check(sum, S(a + c * c), S(b + d * d));
  }
  check(Pair<S>(), S(0.0), S(0.0));
}

}  // namespace

TEST_GROUP(Pair){};

TEST(Pair, lanes_are_what_the_scalar_gives) {
  check_operations<double>();
  check_operations<float>();
  check_operations<FixedQ47>();
}

}  // namespace relnav
