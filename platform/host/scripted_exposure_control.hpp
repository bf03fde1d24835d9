#pragma once
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "hal/exposure_control.hpp"
#include "platform/host/bounded_record.hpp"

namespace relnav::platform::host {

/// A call of set(), with its answer.
struct ExposureCall {
  Status answer = Status::ok;
  hal::Exposure wanted;
  hal::Exposure applied;  ///< ok
};

/// Exposure of a camera that only exists as this: records what is set, in steps if asked to, and fails by script.
class ScriptedExposureControl final : public hal::ExposureControl {
 public:
  explicit ScriptedExposureControl(std::size_t record_capacity = 1024) : calls_(record_capacity) {}

  hal::ExposureLimits offered{Duration{10'000}, Duration{1'000'000'000}, 1.0, 100.0};
  Duration time_step{1};   ///< times are least ones plus multiples of this
  double gain_step = 0.0;  ///< gains likewise; 0: any
  /// Of both calls, while it is not ok: not_configured, device_lost.
  Status state = Status::ok;
  /// The next `count` calls of set() answer `status`, and nothing changes.
  void fail_sets(Status status, std::size_t count = 1) {
    failure_ = status;
    failures_left_ = count;
  }

  [[nodiscard]] const BoundedRecord<ExposureCall>& calls() const { return calls_; }
  /// Time 0: nothing was ever applied.
  [[nodiscard]] const hal::Exposure& applied() const { return applied_; }

  Status limits(hal::ExposureLimits& limits) override {
    if (state != Status::ok) return state;
    limits = offered;
    return Status::ok;
  }
  Status set(const hal::Exposure& wanted, hal::Exposure& applied) override {
    const Status answer = judge(wanted);
    if (answer == Status::ok) applied = applied_ = nearest(wanted);
    calls_.push({answer, wanted, answer == Status::ok ? applied_ : hal::Exposure()});
    return answer;
  }

 private:
  Status judge(const hal::Exposure& wanted) {
    if (state != Status::ok) return state;
    const bool inside = wanted.time >= offered.time_min && wanted.time <= offered.time_max &&
                        wanted.gain >= offered.gain_min && wanted.gain <= offered.gain_max;
    if (!inside) return Status::invalid_argument;
    if (failures_left_ == 0) return Status::ok;
    --failures_left_;
    return failure_;
  }
  [[nodiscard]] hal::Exposure nearest(const hal::Exposure& wanted) const {
    hal::Exposure out = wanted;
    const std::int64_t step_ns = time_step.ns;
    const std::int64_t steps = ((wanted.time.ns - offered.time_min.ns) + step_ns / 2) / step_ns;
    out.time.ns = offered.time_min.ns + steps * step_ns;
    if (out.time > offered.time_max) out.time.ns -= step_ns;
    if (gain_step > 0.0) {
      out.gain = offered.gain_min + gain_step * std::round((wanted.gain - offered.gain_min) / gain_step);
      if (out.gain > offered.gain_max) out.gain -= gain_step;
    }
    return out;
  }

  BoundedRecord<ExposureCall> calls_;
  hal::Exposure applied_;
  Status failure_ = Status::ok;
  std::size_t failures_left_ = 0;
};

}  // namespace relnav::platform::host
