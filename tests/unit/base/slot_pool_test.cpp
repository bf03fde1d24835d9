#include "fsw/base/slot_pool.hpp"

#include <array>
#include <cstdint>

#include "fsw/base/generator.hpp"

#include <CppUTest/TestHarness.h>

using relnav::SlotHandle;
using relnav::SlotPool;
using relnav::Status;

TEST_GROUP(SlotPool) { SlotPool<3> pool; };

TEST(SlotPool, GivesTheLowestFreeSlot) {
  LONGS_EQUAL(3, pool.capacity());
  LONGS_EQUAL(0, pool.acquire().value().index);
  const SlotHandle second = pool.acquire().value();
  LONGS_EQUAL(1, second.index);
  LONGS_EQUAL(2, pool.acquire().value().index);
  CHECK_TRUE(pool.full());
  CHECK_TRUE(pool.release(second) == Status::ok);
  LONGS_EQUAL(2, pool.in_use());
  LONGS_EQUAL(1, pool.acquire().value().index);
}

TEST(SlotPool, FullHasNoCapacity) {
  for (int i = 0; i < 3; ++i) CHECK_TRUE(pool.acquire().has_value());
  CHECK_TRUE(pool.acquire().status() == Status::no_capacity);
  LONGS_EQUAL(3, pool.in_use());
}

TEST(SlotPool, StaleHandleDoesNotTouchTheSuccessor) {
  const SlotHandle first = pool.acquire().value();
  CHECK_TRUE(pool.release(first) == Status::ok);
  const SlotHandle successor = pool.acquire().value();
  LONGS_EQUAL(first.index, successor.index);
  CHECK_FALSE(first == successor);
  CHECK_FALSE(pool.is_current(first));
  CHECK_TRUE(pool.release(first) == Status::stale_handle);
  CHECK_TRUE(pool.is_current(successor));
  CHECK_TRUE(pool.handle_of(successor.index) == successor);
}

TEST(SlotPool, ReleasedTwiceIsStale) {
  const SlotHandle handle = pool.acquire().value();
  CHECK_TRUE(pool.release(handle) == Status::ok);
  CHECK_TRUE(pool.release(handle) == Status::stale_handle);
  LONGS_EQUAL(0, pool.in_use());
}

TEST(SlotPool, HandleThatNamesNothing) {
  CHECK_FALSE(pool.is_current(SlotHandle{}));
  CHECK_TRUE(pool.release(SlotHandle{}) == Status::stale_handle);
  CHECK_TRUE(pool.release(SlotHandle{3, 0}) == Status::stale_handle);
  CHECK_FALSE(pool.is_used(0));
  CHECK_FALSE(pool.is_used(3));
}

TEST(SlotPool, HandlesAreOneOnlyInIndexAndGeneration) {
  const SlotHandle handle{1, 7};
  CHECK_TRUE((handle == SlotHandle{1, 7}));
  CHECK_FALSE((handle == SlotHandle{1, 8}));
  CHECK_FALSE((handle == SlotHandle{2, 7}));
}

// 65536 uses of one slot make its generations begin again: documented reach of the tag.
TEST(SlotPool, GenerationsRepeatAfterAllAreUsed) {
  const SlotHandle first = pool.acquire().value();
  CHECK_TRUE(pool.release(first) == Status::ok);
  for (int i = 1; i < 0x10000; ++i) {
    const SlotHandle handle = pool.acquire().value();
    CHECK_FALSE(pool.is_current(first));
    CHECK_TRUE(pool.release(handle) == Status::ok);
  }
  CHECK_TRUE(pool.acquire().value() == first);
}

TEST(SlotPool, AgreesWithAModelOverARandomHistory) {
  SlotPool<16> big;
  std::array<bool, 16> model{};
  std::array<SlotHandle, 16> handles{};
  std::size_t in_use = 0;
  relnav::Generator generator(2024);
  for (int step = 0; step < 20000; ++step) {
    const std::uint32_t i = generator.below(16);
    if (generator.below(2) == 0) {
      const auto acquired = big.acquire();
      CHECK_TRUE(acquired.has_value() == (in_use < 16));
      if (acquired) {
        CHECK_FALSE(model[acquired.value().index]);
        model[acquired.value().index] = true;
        handles[acquired.value().index] = acquired.value();
        ++in_use;
      }
    } else {
      CHECK_TRUE((big.release(handles[i]) == Status::ok) == model[i]);
      if (model[i]) --in_use;
      model[i] = false;
    }
    LONGS_EQUAL(in_use, big.in_use());
  }
}
