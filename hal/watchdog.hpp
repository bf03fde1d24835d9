#pragma once
#include "fsw/base/status.hpp"

namespace relnav::hal {

/// Watchdog. Contract:
/// WDG-1  kick() is called after a completed step and restarts the deadline.
/// WDG-2  trip() asks for the safe reaction at once (a self-detected fault); kick() afterwards returns device_lost.
class Watchdog {
 public:
  virtual Status kick() = 0;
  virtual Status trip() = 0;

 protected:
  Watchdog() = default;
  Watchdog(const Watchdog&) = default;
  Watchdog& operator=(const Watchdog&) = default;
  ~Watchdog() = default;
};

}  // namespace relnav::hal
