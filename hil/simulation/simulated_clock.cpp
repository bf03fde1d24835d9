#include "hil/simulation/simulated_clock.hpp"

#include <algorithm>
#include <thread>

namespace relnav::hil {

Time SimulatedClock::now() {
  const auto elapsed = std::chrono::duration_cast<std::chrono::nanoseconds>(MachineClock::now() - since_).count();
  return std::min(base_ + Duration{elapsed}, std::max(base_, limit_));
}

void SimulatedClock::advance_to(Time time, Time next) {
  limit_ = std::max(limit_, next);
  if (time <= base_) return;
  if (paced_) std::this_thread::sleep_until(since_ + std::chrono::nanoseconds((time - base_).ns));
  // now() has been up to the old limit, which is not after `time`: it goes on from there.
  base_ = time;
  since_ = MachineClock::now();
}

}  // namespace relnav::hil
