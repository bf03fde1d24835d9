#include "platform/linux/monotonic_clock.hpp"

#include <time.h>

namespace relnav::platform::linux {

Time MonotonicClock::now() {
  timespec now{};
  static_cast<void>(::clock_gettime(CLOCK_MONOTONIC, &now));  // cannot fail for this clock
  return {std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec};
}

}  // namespace relnav::platform::linux
