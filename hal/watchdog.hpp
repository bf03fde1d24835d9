#pragma once
#include "fsw/base/status.hpp"

namespace relnav::hal {

/// Watchdog. Contract (tests/contract/watchdog_contract.hpp):
/// WDG-1  kick(), called after a completed step, restarts the deadline: no reaction while kicks come in time.
/// WDG-2  trip() asks for the safe reaction at once (a self-detected fault); kick() afterwards returns device_lost.
/// WDG-3  Without a kick() the reaction comes when the deadline has passed; kick() afterwards returns device_lost.
/// WDG-4  trip() may be repeated: it returns ok and changes nothing more.
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
