// A set that a chart does not have is our own bug.
#include "fsw/attitude/mrp.hpp"
#include "fsw/attitude/rodrigues.hpp"
#include "tests/support/panics.hpp"

#include <CppUTest/TestHarness.h>

using namespace relnav;

TEST_GROUP(ChartPanic){};

TEST(ChartPanic, SetsThatDoNotExist) {
  const auto mrp = [](int set) {
    return test::panics([&] { static_cast<void>(MrpChart::from_parameters(Vec3::Zero(), set)); });
  };
  CHECK_TRUE(mrp(-1));
  CHECK_FALSE(mrp(0));
  CHECK_FALSE(mrp(1));
  CHECK_TRUE(mrp(2));
  const auto rodrigues = [](int set) {
    return test::panics([&] { static_cast<void>(RodriguesChart::from_parameters(Vec3::Zero(), set)); });
  };
  CHECK_TRUE(rodrigues(-1));
  CHECK_FALSE(rodrigues(0));
  CHECK_FALSE(rodrigues(3));
  CHECK_TRUE(rodrigues(4));
}
