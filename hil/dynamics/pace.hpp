#pragma once

namespace relnav::hil {

/// How a way is shared out over time. smooth: speed and acceleration begin and end with zero (minimum jerk: Flash, Hogan,
/// J. Neuroscience 5(7), 1985, eq. A9). trapezoid: ramps of constant acceleration with constant speed between them.
enum class PaceKind { smooth, constant, trapezoid };

/// Either the duration or the largest speed, and for the trapezoid its acceleration; lengths in the way's own unit.
struct LegPace {
  PaceKind kind = PaceKind::smooth;
  double duration_s = 0.0;  ///< 0: as the speed asks
  double speed = 0.0;
  double acceleration = 0.0;
};

struct PlannedPace {
  PaceKind kind = PaceKind::smooth;
  double duration_s = 0.0;
  double ramp_s = 0.0;
};

struct LegProgress {
  double share = 1.0;  ///< of the way, 0 .. 1
  double rate = 0.0;   ///< 1/s
};

[[nodiscard]] PlannedPace planned(const LegPace& pace, double length);
/// `t_s` after the beginning; done from the duration on.
[[nodiscard]] LegProgress progress(const PlannedPace& pace, double t_s);

}  // namespace relnav::hil
