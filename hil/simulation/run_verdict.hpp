#pragma once
#include <map>
#include <string>
#include <vector>

#include "hil/evaluate/evaluation.hpp"
#include "hil/replay/replay_run.hpp"
#include "hil/simulation/scenario_file.hpp"

namespace relnav::hil {

/// What a run came to, in one word.
enum class RunEnd : std::uint8_t {
  tracked,     ///< kept track from the start to the end
  regained,    ///< lost track and found it again
  lost,        ///< ended without track
  no_pose,     ///< never had one
  wrong_pose,  ///< called a wrong pose valid, whatever else
};
[[nodiscard]] const char* to_string(RunEnd end);

/// A run against its truth.
struct RunVerdict {
  RunEnd end = RunEnd::no_pose;
  std::string problem;  ///< one line, or empty
  std::size_t frames = 0;
  std::size_t poses = 0;
  std::size_t wrong_poses = 0;  ///< called valid, see WrongPoseLimits
  Time first_wrong;
  std::map<std::string, double> figures;
  double nees_sum = 0.0;
  std::size_t nees_count = 0;
  int nees_degrees_of_freedom = 0;
};

/// A known target is the one that the run ends with; the NEES is of its poses (6 degrees of freedom), else of the attitude (3).
[[nodiscard]] bool known_at_end(const SimulationScenario& scenario);

/// How poses of one estimator are compared with the truth.
[[nodiscard]] AlignMode alignment_of(const RunHistory& track);

/// The last kind's poses alone: after a hand-over the frames of the two kinds have nothing in common.
[[nodiscard]] RunHistory last_kind_of(const RunHistory& history);

/// Poses of a cooperative target are compared as they are; those of an unknown one since the start of their track, in attitude, and
/// for position after one scale and one body point were fitted (spec/conventions.md, `--align start`).
/// Figures, over all poses: attitude_{rms,max,last}_deg, position_{rms,max}_m, rate_{mean,max}_deg_s (norm of the error of the rate
/// over a window), angle_error_percent (attitude at the end over the angle turned; unknown target), rms_over_sigma_{x,y,z,rx,ry,rz}
/// (RMS of the error over RMS of the stated sigma: over the Cramer-Rao bound, where the estimator's covariance is that bound),
/// first_pose_s, poses_percent, nees_mean.
[[nodiscard]] RunVerdict judge_run(const SimulationScenario& scenario, const ReplayOutcome& outcome,
                                   const RunHistory& history, const Trajectory& truth);

/// The result file of a run of a campaign: one object of JSON.
[[nodiscard]] std::string result_json(const SimulationScenario& scenario, RunNumber run, const RunVerdict& verdict,
                                      double wall_s);

}  // namespace relnav::hil
