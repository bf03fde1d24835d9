#include "fsw/base/time.hpp"

#include <cstdint>
#include <limits>

#include <CppUTest/TestHarness.h>

using relnav::Duration;
using relnav::Time;

TEST_GROUP(Time){};

TEST(Time, DifferenceAndSum) {
  const Time a{1'700'000'000'000'000'001LL};
  const Time b{1'700'000'000'000'000'000LL};
  CHECK_TRUE(1 == (a - b).ns);
  CHECK_TRUE(-1 == (b - a).ns);
  CHECK_TRUE(b + (a - b) == a);
}

// A double in seconds cannot tell these apart; integers can.
TEST(Time, NanosecondsOfTodayAreExact) {
  const Time a{1'700'000'000'123'456'789LL};
  const Time b{1'700'000'000'123'456'790LL};
  CHECK_TRUE(a < b);
  CHECK_TRUE(a != b);
  CHECK_TRUE(static_cast<double>(a.ns) * 1e-9 >= static_cast<double>(b.ns) * 1e-9);
}

TEST(Time, Order) {
  CHECK_TRUE(Time{1} < Time{2});
  CHECK_TRUE(Time{-1} < Time{0});
  CHECK_TRUE(Time{2} >= Time{2});
  CHECK_FALSE(Time{1} >= Time{2});
  CHECK_FALSE(Time{1} == Time{2});
  CHECK_TRUE(Duration{-5} < Duration{});
  CHECK_FALSE(Duration{5} < Duration{});
  CHECK_TRUE(Duration{5} == Duration{5});
  CHECK_TRUE(Time{std::numeric_limits<std::int64_t>::min()} < Time{std::numeric_limits<std::int64_t>::max()});
}

TEST(Time, Seconds) {
  DOUBLES_EQUAL(1.5, Duration{1'500'000'000}.seconds(), 1e-15);
  DOUBLES_EQUAL(-1e-9, Duration{-1}.seconds(), 1e-24);
  CHECK_TRUE(0 == Time{}.ns);
}
