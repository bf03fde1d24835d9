#pragma once
#include <cstddef>

#include "hal/clock.hpp"

namespace relnav::platform::host {

/// Clock that stands still unless told. Keeps the contract as long as jump_to() is not used to go back.
class ScriptedClock final : public hal::Clock {
 public:
  explicit ScriptedClock(Time start = {}, hal::ClockId id = hal::ClockId::monotonic) : now_(start), id_(id) {}

  /// Gives the time, then advances it by the tick.
  [[nodiscard]] Time now() override {
    const Time reading = now_;
    now_ = now_ + tick_;
    ++calls_;
    return reading;
  }
  [[nodiscard]] hal::ClockId id() const override { return id_; }

  /// Negative lengths count as zero.
  void advance(Duration length) { now_ = now_ + Duration{length.ns > 0 ? length.ns : 0}; }
  /// Also back: a fault.
  void jump_to(Time time) { now_ = time; }
  void set_tick(Duration tick) { tick_ = tick; }
  [[nodiscard]] Time peek() const { return now_; }
  [[nodiscard]] std::size_t calls() const { return calls_; }

 private:
  Time now_;
  Duration tick_;
  hal::ClockId id_;
  std::size_t calls_ = 0;
};

}  // namespace relnav::platform::host
