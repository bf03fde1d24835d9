#pragma once
#include <cstddef>

#include "hal/watchdog.hpp"
#include "platform/host/scripted_clock.hpp"

namespace relnav::platform::host {

/// Watchdog that counts, and whose deadline runs on a scripted clock if one is attached.
class ScriptedWatchdog final : public hal::Watchdog {
 public:
  /// Deadline `timeout` from now and from each kick.
  void attach_clock(ScriptedClock& clock, Duration timeout) {
    clock_ = &clock;
    timeout_ = timeout;
    deadline_ = clock.peek() + timeout;
  }
  /// The next `count` calls of kick() answer `status` and do not restart the deadline.
  void fail_kicks(Status status, std::size_t count = 1) {
    failure_ = status;
    failures_left_ = count;
  }

  [[nodiscard]] std::size_t kicks() const { return kicks_; }
  [[nodiscard]] std::size_t trips() const { return trips_; }
  /// The safe reaction was asked for, by trip() or because the deadline passed.
  [[nodiscard]] bool reacted() {
    if (clock_ != nullptr && clock_->peek() > deadline_) reacted_ = true;
    return reacted_;
  }

  Status kick() override {
    ++kicks_;
    if (reacted()) return Status::device_lost;
    if (failures_left_ > 0) {
      --failures_left_;
      return failure_;
    }
    if (clock_ != nullptr) deadline_ = clock_->peek() + timeout_;
    return Status::ok;
  }
  Status trip() override {
    ++trips_;
    reacted_ = true;
    return Status::ok;
  }

 private:
  ScriptedClock* clock_ = nullptr;
  Duration timeout_;
  Time deadline_;
  Status failure_ = Status::ok;
  std::size_t failures_left_ = 0;
  std::size_t kicks_ = 0;
  std::size_t trips_ = 0;
  bool reacted_ = false;
};

}  // namespace relnav::platform::host
