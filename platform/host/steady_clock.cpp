#include "platform/host/steady_clock.hpp"

#include <chrono>

namespace relnav::platform::host {

Time SteadyClock::now() {
  const auto since_start = std::chrono::steady_clock::now().time_since_epoch();
  return {std::chrono::duration_cast<std::chrono::nanoseconds>(since_start).count()};
}

}  // namespace relnav::platform::host
