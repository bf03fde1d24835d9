#pragma once
#include "hal/clock.hpp"

namespace relnav::platform::mps2 {

/// Time since start() by the processor's own timer. With qemu's -icount shift=0 a nanosecond is an instruction, in steps of a tick.
class SystickClock final : public hal::Clock {
 public:
  static constexpr std::int64_t tick_ns = 40;  ///< the board's 25 MHz

  /// One object only: there is one timer.
  void start();
  [[nodiscard]] Time now() override;
  [[nodiscard]] hal::ClockId id() const override { return hal::ClockId::monotonic; }
};

}  // namespace relnav::platform::mps2
