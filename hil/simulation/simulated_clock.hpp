#pragma once
#include <chrono>

#include "hal/clock.hpp"

namespace relnav::hil {

/// Simulated time: it moves when the simulated camera waits for its next frame. In between it goes on with the machine's clock,
/// so that stages take the time they take, but never reaches the next frame's: a slow machine changes no result.
class SimulatedClock final : public hal::Clock {
 public:
  /// `paced`: as fast as time goes; otherwise as fast as possible.
  SimulatedClock(Time start, bool paced) : base_(start), limit_(start), paced_(paced) {}

  [[nodiscard]] Time now() override;
  [[nodiscard]] hal::ClockId id() const override { return hal::ClockId::tai; }
  /// Waits until `time` (nothing if it is past); now() stays before `next` from then on.
  void advance_to(Time time, Time next);
  /// The time reached by advance_to().
  [[nodiscard]] Time simulated() const { return base_; }

 private:
  using MachineClock = std::chrono::steady_clock;
  Time base_;
  Time limit_;
  bool paced_;
  MachineClock::time_point since_ = MachineClock::now();
};

}  // namespace relnav::hil
