#include "fsw/base/expected.hpp"

#include <type_traits>

#include <CppUTest/TestHarness.h>

using relnav::Expected;
using relnav::Status;

TEST_GROUP(Expected){};

static_assert(!std::is_default_constructible_v<Expected<int>>);

TEST(Expected, HoldsAValue) {
  const Expected<int> value = 42;
  CHECK_TRUE(value.has_value());
  CHECK_TRUE(static_cast<bool>(value));
  CHECK_TRUE(value.status() == Status::ok);
  LONGS_EQUAL(42, value.value());
  LONGS_EQUAL(42, value.value_or(7));
}

TEST(Expected, HoldsTheReasonForNoValue) {
  const Expected<int> none = Status::timeout;
  CHECK_FALSE(none.has_value());
  CHECK_FALSE(static_cast<bool>(none));
  CHECK_TRUE(none.status() == Status::timeout);
  LONGS_EQUAL(7, none.value_or(7));
}

TEST(Expected, AValueEqualToADefaultIsStillAValue) { CHECK_TRUE(Expected<int>(0).has_value()); }
