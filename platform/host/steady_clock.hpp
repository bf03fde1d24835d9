#pragma once
#include "hal/clock.hpp"

namespace relnav::platform::host {

/// The host's monotonic clock.
class SteadyClock final : public hal::Clock {
 public:
  [[nodiscard]] Time now() override;
  [[nodiscard]] hal::ClockId id() const override { return hal::ClockId::monotonic; }
};

}  // namespace relnav::platform::host
