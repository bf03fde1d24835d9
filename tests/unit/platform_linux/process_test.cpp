// Signals and real-time rights: each in a process of its own, since they last.
#include <CppUTest/TestHarness.h>
#include <poll.h>
#include <sched.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <string>

#include "platform/linux/realtime.hpp"
#include "platform/linux/signals.hpp"

namespace {

using relnav::platform::linux::become_realtime;
using relnav::platform::linux::note_stop_signals;
using relnav::platform::linux::stop_requested;

/// Status of the child that runs `body`, as waitpid() gives it.
template <typename Body>
int in_a_child(Body body) {
  const pid_t child = ::fork();
  if (child == 0) ::_exit(body());
  int status = -1;
  ::waitpid(child, &status, 0);
  return status;
}

/// kB of this process that are locked. (Not used under the address sanitizer, as the next one.)
[[maybe_unused]] long locked_kb() {
  std::ifstream file("/proc/self/status");
  for (std::string line; std::getline(file, line);) {
    if (line.rfind("VmLck:", 0) == 0) return std::stol(line.substr(6));
  }
  return -1;
}

[[maybe_unused]] bool be_nobody() { return ::setgid(65534) == 0 && ::setuid(65534) == 0; }

}  // namespace

TEST_GROUP(Signals){};

TEST(Signals, OneIsNotedTheSecondEndsTheProgram) {
  for (const int signal : {SIGTERM, SIGINT}) {
    const int status = in_a_child([signal] {
      note_stop_signals();
      if (stop_requested()) return 1;
      ::raise(signal);
      if (!stop_requested()) return 2;
      ::raise(signal);
      return 3;
    });
    CHECK_TRUE(WIFSIGNALED(status));
    LONGS_EQUAL(signal, WTERMSIG(status));
  }
}

TEST(Signals, WaitsEndEarlyAndABrokenPipeIsAnError) {
  const int status = in_a_child([] {
    note_stop_signals();
    itimerval soon{};
    soon.it_value.tv_usec = 20'000;
    static_cast<void>(::signal(SIGALRM, [](int) { ::kill(::getpid(), SIGTERM); }));
    static_cast<void>(::setitimer(ITIMER_REAL, &soon, nullptr));
    while (!stop_requested()) {
      if (::poll(nullptr, 0, 10'000) == 0) return 1;  // the whole time
    }
    int ends[2] = {};
    if (::pipe(ends) != 0) return 2;
    ::close(ends[0]);
    return ::write(ends[1], "x", 1) < 0 ? 0 : 3;
  });
  CHECK_TRUE(WIFEXITED(status));
  LONGS_EQUAL(0, WEXITSTATUS(status));
}

TEST_GROUP(Realtime){};

#ifndef __SANITIZE_ADDRESS__  // the address sanitizer makes nothing of mlockall()
TEST(Realtime, GrantsWhatIsAllowedAndSaysWhatIsNot) {
  const int status = in_a_child([] {
    const std::string problem = become_realtime({true, 10});
    const bool has_priority = ::sched_getscheduler(0) == (SCHED_FIFO | SCHED_RESET_ON_FORK);
    const bool names_priority = problem.find("no real-time priority 10") != std::string::npos;
    if (has_priority == names_priority) return 1;
    const bool names_memory = problem.find("memory is not locked") != std::string::npos;
    if ((locked_kb() > 0) == names_memory) return 2;
    return problem.find('\n') == std::string::npos ? 0 : 3;
  });
  CHECK_TRUE(WIFEXITED(status));
  LONGS_EQUAL(0, WEXITSTATUS(status));
}

TEST(Realtime, APlainUserWithoutLimitsGoesOnWithoutAndIsTold) {
  const int status = in_a_child([] {
    const rlimit none{0, 0};
    if (::setrlimit(RLIMIT_MEMLOCK, &none) != 0 || ::setrlimit(RLIMIT_RTPRIO, &none) != 0) return 1;
    if (::geteuid() == 0 && !be_nobody()) return 2;
    const std::string problem = become_realtime({true, 10});
    if (problem.find("memory is not locked: ") != 0) return 3;
    if (problem.find("LimitMEMLOCK=infinity") == std::string::npos) return 4;
    if (problem.find("; no real-time priority 10: ") == std::string::npos) return 5;
    return 0;
  });
  CHECK_TRUE(WIFEXITED(status));
  LONGS_EQUAL(0, WEXITSTATUS(status));
}

/// A limit that fits what is there now must not make a later allocation fail.
TEST(Realtime, ALimitDoesNotFailLaterAllocations) {
  const int status = in_a_child([] {
    rlimit limit{};
    if (::getrlimit(RLIMIT_MEMLOCK, &limit) != 0) return 1;
    limit.rlim_cur = std::min<rlim_t>(limit.rlim_max, 64U << 20U);
    if (::setrlimit(RLIMIT_MEMLOCK, &limit) != 0) return 1;
    if (::geteuid() == 0 && !be_nobody()) return 2;
    const std::string problem = become_realtime({true, 0});
    // Which of the two depends on the limit that this machine allows.
    const bool locked = problem.find("memory is locked as it is now") == 0;
    if (!locked && problem.find("memory is not locked: ") != 0) return 3;
    if (locked != (locked_kb() > 0)) return 4;
    char* const later = new char[100U << 20U];
    std::memset(later, 1, 100U << 20U);
    const bool held = later[12345] == 1;
    delete[] later;
    return held ? 0 : 5;
  });
  CHECK_TRUE(WIFEXITED(status));
  LONGS_EQUAL(0, WEXITSTATUS(status));
}
#endif

TEST(Realtime, NoWishesNoAnswer) { STRCMP_EQUAL("", become_realtime({false, 0}).c_str()); }
