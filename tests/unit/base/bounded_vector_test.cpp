#include "fsw/base/bounded_vector.hpp"

#include <numeric>

#include <CppUTest/TestHarness.h>

using relnav::BoundedVector;
using relnav::Status;

TEST_GROUP(BoundedVector) {
  BoundedVector<int, 3> v;
  void fill() {
    for (int i = 1; i <= 3; ++i) CHECK_TRUE(v.push_back(i * 10) == Status::ok);
  }
};

TEST(BoundedVector, StartsEmpty) {
  CHECK_TRUE(v.empty());
  CHECK_FALSE(v.full());
  LONGS_EQUAL(0, v.size());
  LONGS_EQUAL(3, v.capacity());
  CHECK_TRUE(v.begin() == v.end());
}

TEST(BoundedVector, KeepsOrder) {
  fill();
  CHECK_TRUE(v.full());
  LONGS_EQUAL(10, v[0]);
  LONGS_EQUAL(30, v[2]);
  LONGS_EQUAL(60, std::accumulate(v.begin(), v.end(), 0));
  CHECK_TRUE(v.data() + 2 == &v[2]);
  const auto& constant = v;
  CHECK_TRUE(constant.data() == v.data());
  CHECK_TRUE(&constant[2] == &v[2]);
}

TEST(BoundedVector, FullRefusesAndStaysUnchanged) {
  fill();
  CHECK_TRUE(v.push_back(99) == Status::no_capacity);
  LONGS_EQUAL(3, v.size());
  LONGS_EQUAL(30, v[2]);
}

TEST(BoundedVector, PopTruncateClear) {
  fill();
  v.pop_back();
  LONGS_EQUAL(2, v.size());
  v.truncate(2);
  LONGS_EQUAL(2, v.size());
  v.truncate(1);
  LONGS_EQUAL(1, v.size());
  LONGS_EQUAL(10, v[0]);
  v.clear();
  CHECK_TRUE(v.empty());
  fill();
  CHECK_TRUE(v.full());
}
