#pragma once
#include <net/if.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstring>

namespace relnav {

/// Puts the process into a network of its own, with nothing but the loopback interface: port 3956 is free, and tests that run
/// at the same time do not meet. Where that is not allowed everything stays as it is. Before any thread is started.
inline void enter_own_network() {
  static bool done = false;
  if (done) return;
  done = true;
  if (::unshare(CLONE_NEWNET) != 0 && ::unshare(CLONE_NEWUSER | CLONE_NEWNET) != 0) return;
  const int socket = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  ifreq request{};
  std::strcpy(request.ifr_name, "lo");
  if (socket >= 0 && ::ioctl(socket, SIOCGIFFLAGS, &request) == 0) {
    request.ifr_flags = static_cast<short>(request.ifr_flags | IFF_UP | IFF_RUNNING);
    static_cast<void>(::ioctl(socket, SIOCSIFFLAGS, &request));
  }
  ::close(socket);
}

}  // namespace relnav
