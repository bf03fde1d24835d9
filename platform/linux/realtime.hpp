#pragma once
#include <string>

namespace relnav::platform::linux {

struct RealtimeWishes {
  bool lock_memory = true;
  int priority = 0;  ///< SCHED_FIFO, 1 to 99; 0: the ordinary scheduler
};

/// Locks the process's memory, touches the stack that the loop will need, and gives the calling thread its priority, as far as
/// the system allows. Call it once all memory is taken. Goes on without what is not allowed; the answer says in one line what
/// that is and which limit it needs, empty when everything was granted.
[[nodiscard]] std::string become_realtime(const RealtimeWishes& wishes);

}  // namespace relnav::platform::linux
