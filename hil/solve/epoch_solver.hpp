#pragma once
#include <string>

#include "fsw/app/step_report.hpp"
#include "fsw/estimation/cooperative_estimator.hpp"
#include "fsw/estimation/pose_filter.hpp"

namespace relnav::hil {

enum class SolveScalar : std::uint8_t { in_double, in_float, in_fixed };

struct SolveSetup {
  CooperativeConfig config;
  SolveScalar scalar = SolveScalar::in_double;
  bool switching =
      true;  ///< of the Rodrigues sets; false: no acquisition after the first epoch either, so that it shows
};

/// Poses from identified observations, epoch by epoch: what the flight code's estimator says, with the motion filter behind
/// it for the rates.
class EpochSolver {
 public:
  /// Throws std::runtime_error when the estimator refuses.
  EpochSolver(const SolveSetup& setup, const CameraRig& rig, const TargetModel& target);

  /// As the flight loop's: status ok with a pose in state, or why there is none. ambiguous: the better pose is in state, not to
  /// be taken as valid.
  const app::StepReport& solve(Time time, const PoseObservations& observations);

 private:
  Status solve_double(const PoseObservations& observations, const Pose* prior);
  Status solve_narrow(const PoseObservations& observations, const Pose* prior);
  Status solve_narrow_motor(const PoseObservations& observations);
  void report(Time time, const PoseObservations& observations, Status status);

  SolveSetup setup_;
  CooperativeEstimator estimator_;
  PoseFilter filter_;
  Pose previous_;
  bool has_previous_ = false;
  CooperativeSolution solution_;
  app::StepReport report_;
};

}  // namespace relnav::hil
