#include "platform/linux/signals.hpp"

#include <signal.h>

namespace relnav::platform::linux {
namespace {

volatile sig_atomic_t stop = 0;

void note(int) { stop = 1; }

}  // namespace

void note_stop_signals() {
  struct sigaction action = {};
  action.sa_handler = note;
  action.sa_flags = static_cast<int>(SA_RESETHAND);           // and not SA_RESTART
  static_cast<void>(::sigaction(SIGTERM, &action, nullptr));  // fails for signals that do not exist only
  static_cast<void>(::sigaction(SIGINT, &action, nullptr));
  action.sa_handler = SIG_IGN;
  action.sa_flags = 0;
  static_cast<void>(::sigaction(SIGPIPE, &action, nullptr));
}

bool stop_requested() { return stop != 0; }

}  // namespace relnav::platform::linux
