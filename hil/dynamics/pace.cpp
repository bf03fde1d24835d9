#include "hil/dynamics/pace.hpp"

#include <cmath>

namespace relnav::hil {

PlannedPace planned(const LegPace& pace, double length) {
  constexpr double smooth_peak_over_mean = 1.875;
  PlannedPace plan{pace.kind, pace.duration_s, 0.0};
  if (pace.duration_s > 0.0 || length <= 0.0) return plan;
  switch (pace.kind) {
    case PaceKind::smooth: plan.duration_s = smooth_peak_over_mean * length / pace.speed; break;
    case PaceKind::constant: plan.duration_s = length / pace.speed; break;
    case PaceKind::trapezoid:
      // Too short a way for the speed: two ramps that meet.
      plan.ramp_s = std::fmin(pace.speed / pace.acceleration, std::sqrt(length / pace.acceleration));
      plan.duration_s = plan.ramp_s + length / (pace.acceleration * plan.ramp_s);
      break;
  }
  return plan;
}

LegProgress progress(const PlannedPace& pace, double t_s) {
  const double left_s = pace.duration_s - t_s;
  if (left_s <= 0.0) return {};
  const double tau = t_s / pace.duration_s;
  if (pace.kind == PaceKind::constant) return {tau, 1.0 / pace.duration_s};
  if (pace.kind == PaceKind::smooth) {
    const double slope = 30.0 * tau * tau * (1.0 - tau) * (1.0 - tau);
    return {tau * tau * tau * (10.0 - 15.0 * tau + 6.0 * tau * tau), slope / pace.duration_s};
  }
  const double peak = 1.0 / (pace.duration_s - pace.ramp_s);
  if (t_s < pace.ramp_s) return {0.5 * peak * t_s * t_s / pace.ramp_s, peak * t_s / pace.ramp_s};
  if (left_s < pace.ramp_s) return {1.0 - 0.5 * peak * left_s * left_s / pace.ramp_s, peak * left_s / pace.ramp_s};
  return {peak * (t_s - 0.5 * pace.ramp_s), peak};
}

}  // namespace relnav::hil
