#include "platform/mps2/systick_clock.hpp"

#include "platform/mps2/registers.hpp"

namespace {
volatile std::uint32_t wraps = 0;
}

extern "C" void systick_handler();
void systick_handler() { wraps = wraps + 1U; }

namespace relnav::platform::mps2 {
namespace {
constexpr std::uint32_t period = 1U << 24U;  // ticks
constexpr std::uint32_t systick_pending = 1U << 26U;
}  // namespace

void SystickClock::start() {
  SystickReload::write(period - 1U);
  SystickValue::write(0);
  SystickControl::write(7);            // on, interrupt, processor's clock
  while (SystickValue::read() == 0) {  // until it has taken the period over: 0 would look like its end
  }
}

Time SystickClock::now() {
  std::uint32_t before = 0;
  std::uint32_t left = 0;
  bool pending = false;
  do {  // again if the timer wrapped in between
    before = wraps;
    left = SystickValue::read();
    pending = (InterruptControl::read() & systick_pending) != 0;
  } while (before != wraps);
  if (pending && left > period / 2U) ++before;  // wrapped, but not yet counted
  const std::int64_t ticks = static_cast<std::int64_t>(before) * period + (period - 1U - left);
  return Time{ticks * tick_ns};
}

}  // namespace relnav::platform::mps2
