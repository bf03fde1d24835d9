#pragma once
#include <sys/types.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>

/// Of clang's profile runtime, where it is linked: what a process has counted is lost when it aborts.
extern "C" int __llvm_profile_write_file() __attribute__((weak));

namespace relnav::test {

/// Whether `action` ends in panic(), which aborts on a host: tried in a process of its own.
template <typename Action>
bool panics(Action action) {
  const pid_t child = fork();
  if (child == 0) {
    close(STDERR_FILENO);
    std::signal(SIGABRT, [](int) {
      if (&__llvm_profile_write_file != nullptr) __llvm_profile_write_file();
    });  // and then abort() goes on
    action();
    _exit(0);
  }
  int state = 0;
  waitpid(child, &state, 0);
  return WIFSIGNALED(state) && WTERMSIG(state) == SIGABRT;
}

}  // namespace relnav::test
