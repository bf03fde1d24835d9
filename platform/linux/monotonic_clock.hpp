#pragma once
#include "hal/clock.hpp"

namespace relnav::platform::linux {

/// CLOCK_MONOTONIC: the kernel stamps frames and edges with it. Stands still while the machine sleeps.
class MonotonicClock final : public hal::Clock {
 public:
  [[nodiscard]] Time now() override;
  [[nodiscard]] hal::ClockId id() const override { return hal::ClockId::monotonic; }
};

}  // namespace relnav::platform::linux
