#include "platform/linux/realtime.hpp"

#include <sched.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>

namespace relnav::platform::linux {
namespace {

/// Pages that are touched now are no page faults later.
[[gnu::noinline]] void touch_stack() {
  std::array<volatile char, 256 * 1024> room;  // NOLINT(cppcoreguidelines-pro-type-member-init)
  const auto page = static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
  for (std::size_t i = 0; i < room.size(); i += page) room[i] = 0;
}

std::string lock_memory() {
  rlimit limit{};
  const bool known = ::getrlimit(RLIMIT_MEMLOCK, &limit) == 0;
  // Under a limit, MCL_FUTURE would make allocations fail once it is reached: worse than a page fault.
  const bool unlimited = ::geteuid() == 0 || (known && limit.rlim_cur == RLIM_INFINITY);
  const std::string cure = " (needs LimitMEMLOCK=infinity, ulimit -l unlimited)";
  if (::mlockall(unlimited ? MCL_CURRENT | MCL_FUTURE : MCL_CURRENT) != 0) {
    return "memory is not locked: " + std::string(std::strerror(errno)) + cure;
  }
  return unlimited ? "" : "memory is locked as it is now, not what is taken later" + cure;
}

std::string raise_priority(int priority) {
  sched_param parameters{};
  parameters.sched_priority = priority;
  if (::sched_setscheduler(0, SCHED_FIFO | SCHED_RESET_ON_FORK, &parameters) == 0) return "";
  return "no real-time priority " + std::to_string(priority) + ": " + std::strerror(errno) +
         " (needs LimitRTPRIO=" + std::to_string(priority) + ", ulimit -r)";
}

}  // namespace

std::string become_realtime(const RealtimeWishes& wishes) {
  std::string problem;
  if (wishes.lock_memory) {
    touch_stack();
    problem = lock_memory();
  }
  if (wishes.priority > 0) {
    const std::string refused = raise_priority(wishes.priority);
    if (!problem.empty() && !refused.empty()) problem += "; ";
    problem += refused;
  }
  return problem;
}

}  // namespace relnav::platform::linux
