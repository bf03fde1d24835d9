#include "fsw/base/status.hpp"

#include <cstdint>
#include <set>
#include <string>

#include <CppUTest/TestHarness.h>

using relnav::Status;

TEST_GROUP(Status){};

TEST(Status, OkIsZero) { LONGS_EQUAL(0, static_cast<int>(Status::ok)); }

TEST(Status, EveryValueHasItsOwnName) {
  std::set<std::string> names;
  for (int i = 0; i <= static_cast<int>(Status::unfinished); ++i) {
    const std::string name = relnav::to_string(static_cast<Status>(i));
    CHECK_TRUE(name != "unknown");
    CHECK_TRUE(names.insert(name).second);
  }
  STRCMP_EQUAL("unknown", relnav::to_string(static_cast<Status>(static_cast<int>(Status::unfinished) + 1)));
}

// The numbers go into packets: a change is a change of the ICD.
TEST(Status, NumbersInPacketsDoNotMove) {
  LONGS_EQUAL(1, static_cast<int>(Status::invalid_argument));
  LONGS_EQUAL(7, static_cast<int>(Status::device_lost));
  LONGS_EQUAL(13, static_cast<int>(Status::not_positive_definite));
  LONGS_EQUAL(19, static_cast<int>(Status::unsupported));
  LONGS_EQUAL(21, static_cast<int>(Status::inconsistent));
  LONGS_EQUAL(22, static_cast<int>(Status::unfinished));
}
