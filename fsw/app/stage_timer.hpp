#pragma once
#include "fsw/base/time.hpp"
#include "hal/clock.hpp"

namespace relnav::app {

/// Times the stages of a step, one after the other.
class StageTimer {
 public:
  explicit StageTimer(hal::Clock& clock) : clock_(clock), since_(clock.now()) {}
  /// Nanoseconds since the last lap, or since the beginning.
  [[nodiscard]] std::int64_t lap() {
    const Time now = clock_.now();
    const std::int64_t ns = (now - since_).ns;
    since_ = now;
    return ns;
  }

 private:
  hal::Clock& clock_;
  Time since_;
};

}  // namespace relnav::app
