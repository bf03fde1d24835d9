#pragma once
#include "fsw/base/time.hpp"
#include "hal/frame.hpp"

namespace relnav::hal {

/// Monotonic clock. Contract (tests/contract/clock_contract.hpp):
/// CLK-1  now() never goes back.
/// CLK-2  id() names the time scale of now() and does not change.
class Clock {
 public:
  [[nodiscard]] virtual Time now() = 0;
  [[nodiscard]] virtual ClockId id() const = 0;

 protected:
  Clock() = default;
  Clock(const Clock&) = default;
  Clock& operator=(const Clock&) = default;
  ~Clock() = default;
};

}  // namespace relnav::hal
