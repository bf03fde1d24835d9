// Seeded violations: each way to the heap must be seen by the trap that guards step() in the system tests.
#include <array>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include <sys/wait.h>
#include <unistd.h>
#include <csignal>

#include "tests/support/allocation_trap.hpp"

#include <CppUTest/TestHarness.h>

using relnav::test::AllocationTrap;

namespace {

// Keeps the compiler from removing an allocation that nobody looks at.
void* volatile sink = nullptr;

struct Counts {
  std::size_t allocations;
  std::size_t releases;
};

template <typename Action>
Counts counts_of(Action action) {
  const AllocationTrap trap;
  action();
  return {trap.allocations(), trap.releases()};
}

// Status of a child process that runs the action under an aborting trap.
template <typename Action>
int status_under_aborting_trap(Action action) {
  const pid_t child = fork();
  if (child == 0) {
    close(STDERR_FILENO);  // the expected message is not for the log
    const AllocationTrap trap(AllocationTrap::Reaction::abort);
    action();
    _exit(0);
  }
  int status = 0;
  waitpid(child, &status, 0);
  return status;
}

}  // namespace

TEST_GROUP(AllocationTrap){};

TEST(AllocationTrap, sees_nothing_where_there_is_nothing) {
  const Counts counts = counts_of([] {
    std::array<double, 64> values{};
    values[3] = 1.0;
    sink = values.data();
    sink = nullptr;
    std::free(nullptr);
  });
  LONGS_EQUAL(0, counts.allocations);
  LONGS_EQUAL(0, counts.releases);
}

TEST(AllocationTrap, sees_malloc_and_free) {
  const Counts counts = counts_of([] {
    sink = std::malloc(24);
    std::free(sink);
  });
  LONGS_EQUAL(1, counts.allocations);
  LONGS_EQUAL(1, counts.releases);
}

TEST(AllocationTrap, sees_calloc_realloc_and_aligned_memory) {
  CHECK(counts_of([] { sink = std::calloc(3, 8); }).allocations >= 1);
  CHECK(counts_of([] { sink = std::realloc(sink, 4096); }).allocations >= 1);
  std::free(sink);
  CHECK(counts_of([] { sink = std::aligned_alloc(64, 128); }).allocations >= 1);
  std::free(sink);
}

TEST(AllocationTrap, sees_a_vector_growing) {
  std::vector<double> values;
  const Counts counts = counts_of([&values] {
    values.push_back(1.0);
    sink = values.data();
  });
  sink = nullptr;
  CHECK(counts.allocations >= 1);
}

TEST(AllocationTrap, sees_what_the_c_library_does_inside) {
  const Counts counts = counts_of([] { sink = strdup("inside libc.so"); });
  std::free(sink);
  sink = nullptr;
  CHECK(counts.allocations >= 1);
}

TEST(AllocationTrap, keeps_the_size_of_the_first) {
  std::size_t first = 0;
  {
    const AllocationTrap trap;
    sink = std::malloc(1234);
    first = trap.first_size();
  }
  std::free(sink);
  LONGS_EQUAL(1234, first);
}

TEST(AllocationTrap, ends_with_its_scope) {
  { const AllocationTrap trap; }
  sink = std::malloc(8);
  std::free(sink);
  const Counts counts = counts_of([] {});
  LONGS_EQUAL(0, counts.allocations);
}

TEST(AllocationTrap, aborts_when_told_to) {
  const int with = status_under_aborting_trap([] { sink = std::malloc(8); });
  CHECK(WIFSIGNALED(with));
  LONGS_EQUAL(SIGABRT, WTERMSIG(with));
  const int without = status_under_aborting_trap([] { sink = nullptr; });
  CHECK(WIFEXITED(without));
}
