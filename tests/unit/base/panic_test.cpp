#include "fsw/base/panic.hpp"
#include "fsw/base/bounded_vector.hpp"
#include "fsw/base/expected.hpp"
#include "fsw/base/slot_pool.hpp"
#include "tests/support/panics.hpp"

#include <CppUTest/TestHarness.h>

using relnav::test::panics;

TEST_GROUP(Panic){};

TEST(Panic, AssertLetsATrueConditionPass) {
  CHECK_FALSE(panics([] { RELNAV_ASSERT(1 + 1 == 2); }));
}
TEST(Panic, AssertStopsOnAFalseCondition) {
  CHECK_TRUE(panics([] { RELNAV_ASSERT(1 + 1 == 3); }));
}
TEST(Panic, VectorIndexAtSize) {
  CHECK_TRUE(panics([] {
    relnav::BoundedVector<int, 4> v;
    static_cast<void>(v.push_back(1));
    v[1] = 2;
  }));
  CHECK_TRUE(panics([] {
    const relnav::BoundedVector<int, 4> v;
    static_cast<void>(v[0]);
  }));
}
TEST(Panic, VectorPopOfNothing) {
  CHECK_TRUE(panics([] { relnav::BoundedVector<int, 4>{}.pop_back(); }));
}
TEST(Panic, VectorTruncateToMore) {
  CHECK_TRUE(panics([] { relnav::BoundedVector<int, 4>{}.truncate(1); }));
}
TEST(Panic, ExpectedValueOfNone) {
  CHECK_TRUE(panics([] { static_cast<void>(relnav::Expected<int>(relnav::Status::timeout).value()); }));
}
TEST(Panic, ExpectedErrorThatIsOk) {
  CHECK_TRUE(panics([] { static_cast<void>(relnav::Expected<int>(relnav::Status::ok)); }));
}
TEST(Panic, HandleOfAFreeSlot) {
  CHECK_TRUE(panics([] { static_cast<void>(relnav::SlotPool<4>{}.handle_of(0)); }));
  CHECK_TRUE(panics([] { static_cast<void>(relnav::SlotPool<4>{}.handle_of(4)); }));
}
