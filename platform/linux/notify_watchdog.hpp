#pragma once
#include "hal/clock.hpp"
#include "hal/watchdog.hpp"
#include "platform/linux/service_notifier.hpp"

namespace relnav::platform::linux {

/// The service manager's watchdog: it ends a program that is not heard of for `interval` and starts it anew.
///
/// Kicks reach the manager at most every quarter of the interval, so that for it the deadline is between 3/4 and the whole of
/// the interval after the latest kick: kick at least every 3/4. Without a manager, or with interval 0, nobody reacts, but with an
/// interval the deadline is kept all the same.
class NotifyWatchdog final : public hal::Watchdog {
 public:
  /// The first deadline is `interval` from now.
  NotifyWatchdog(ServiceNotifier& notifier, hal::Clock& clock, Duration interval)
      : notifier_(notifier), clock_(clock), interval_(interval), kicked_(clock.now()), told_(kicked_), heard_(false) {}

  /// Else the status of ServiceNotifier::send(): the manager was not told, and is again at the next kick.
  Status kick() override {
    const Time now = clock_.now();
    // Late by our own clock: the manager may not have looked yet, and must not be talked out of it.
    if (tripped_ || (interval_.ns > 0 && now - kicked_ > interval_)) {
      static_cast<void>(trip());
      return Status::device_lost;
    }
    if (interval_.ns <= 0) return Status::ok;
    kicked_ = now;
    if (heard_ && (now - told_).ns < interval_.ns / 4) return Status::ok;
    const Status status = notifier_.watchdog();
    heard_ = status == Status::ok;
    if (heard_) told_ = now;
    return status;
  }

  /// Is sent again by further calls of either kind, until the manager's socket takes it. No kick is sent any more in any case.
  Status trip() override {
    tripped_ = true;
    if (!asked_) asked_ = notifier_.trigger_watchdog() == Status::ok;
    return Status::ok;
  }

 private:
  ServiceNotifier& notifier_;
  hal::Clock& clock_;
  Duration interval_;
  Time kicked_;
  Time told_;
  bool heard_;
  bool tripped_ = false;
  bool asked_ = false;
};

}  // namespace relnav::platform::linux
