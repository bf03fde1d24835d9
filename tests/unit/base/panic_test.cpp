#include <sys/types.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>

#include "fsw/base/bounded_vector.hpp"
#include "fsw/base/expected.hpp"
#include "fsw/base/panic.hpp"
#include "fsw/base/slot_pool.hpp"

#include <CppUTest/TestHarness.h>

namespace {

/// Whether `action` ends in panic(), which aborts on a host.
template <typename Action>
bool panics(Action action) {
  const pid_t child = fork();
  if (child == 0) {
    close(STDERR_FILENO);
    action();
    _exit(0);
  }
  int state = 0;
  waitpid(child, &state, 0);
  return WIFSIGNALED(state) && WTERMSIG(state) == SIGABRT;
}

}  // namespace

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
}
