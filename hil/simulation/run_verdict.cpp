#include "hil/simulation/run_verdict.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "hil/evaluate/rotation.hpp"
#include "hil/replay/summary.hpp"
#include "platform/files/text.hpp"

namespace relnav::hil {
namespace {

constexpr std::array<const char*, 6> axis_names{"x", "y", "z", "rx", "ry", "rz"};

/// Poses of one estimator, of an unknown target between two restarts: its frame is a new one after each.
std::vector<RunHistory> tracks_of(const RunHistory& history) {
  std::vector<RunHistory> tracks(1);
  for (const FrameRecord& record : history.frames) {
    if (!record.has_pose) continue;
    RunHistory& track = tracks.back();
    const bool anew =
        !track.frames.empty() && (track.frames.back().known_target != record.known_target ||
                                  (!record.known_target && track.frames.back().reset_counter != record.reset_counter));
    if (anew) tracks.emplace_back();
    tracks.back().frames.push_back(record);
  }
  return tracks;
}

/// Sums over the epochs of all tracks.
class Tally {
 public:
  explicit Tally(const SimulationScenario& scenario) : scenario_(scenario) {}

  void add(const Evaluation& evaluation, const RunHistory& track) {
    std::map<std::int64_t, const FrameRecord*> record_at;
    for (const FrameRecord& r : track.frames) record_at[r.state.time.ns] = &r;
    for (const EpochError& epoch : evaluation.epochs) {
      const auto found = record_at.find(epoch.time.ns);
      if (found != record_at.end()) add(epoch, *found->second);
    }
    for (const EpochRate& rate : evaluation.rates) {
      const double error = (rate.truth_omega_C - rate.estimate_omega_C).norm();
      rate_sum_ += error;
      rate_max_ = std::max(rate_max_, error);
      ++rates_;
    }
    const bool known = track.frames.front().known_target;
    if (!known && evaluation.angle_turned > 0.0) {
      angle_error_ = std::max(angle_error_, evaluation.attitude.last / evaluation.angle_turned);
      has_angle_ = true;
    }
  }

  void finish(RunVerdict& verdict) const {
    if (count_ == 0) return;
    const double n = static_cast<double>(count_);
    auto& f = verdict.figures;
    f["attitude_rms_deg"] = degrees_per_radian * std::sqrt(attitude_squares_ / n);
    f["attitude_max_deg"] = degrees_per_radian * attitude_max_;
    f["attitude_last_deg"] = degrees_per_radian * attitude_last_;
    f["position_rms_m"] = std::sqrt(position_squares_ / n);
    f["position_max_m"] = position_max_;
    if (rates_ > 0) {
      f["rate_mean_deg_s"] = degrees_per_radian * rate_sum_ / static_cast<double>(rates_);
      f["rate_max_deg_s"] = degrees_per_radian * rate_max_;
    }
    const bool unknown = !known_at_end(scenario_);
    if (has_angle_) f["angle_error_percent"] = 100.0 * angle_error_;
    for (int axis = unknown ? 3 : 0; axis < 6; ++axis) {
      if (variances_(axis) > 0.0)
        f[std::string("rms_over_sigma_") + axis_names[static_cast<std::size_t>(axis)]] =
            std::sqrt(squares_(axis) / variances_(axis));
    }
    verdict.wrong_poses = wrong_;
    verdict.first_wrong = first_wrong_;
    verdict.nees_sum = nees_sum_;
    verdict.nees_count = nees_count_;
    if (nees_count_ > 0) f["nees_mean"] = nees_sum_ / static_cast<double>(nees_count_);
  }

 private:
  void add(const EpochError& epoch, const FrameRecord& record) {
    const Vec6 variance = record.state.pose_covariance.diagonal().cwiseMax(0.0);
    Vec6 error;
    error << epoch.position, epoch.attitude;
    squares_ += error.cwiseAbs2();
    variances_ += variance;
    attitude_squares_ += epoch.attitude.squaredNorm();
    position_squares_ += epoch.position.squaredNorm();
    attitude_max_ = std::max(attitude_max_, epoch.attitude.norm());
    position_max_ = std::max(position_max_, epoch.position.norm());
    attitude_last_ = epoch.attitude.norm();
    ++count_;
    if (epoch.nees && record.known_target == known_at_end(scenario_)) {
      nees_sum_ += *epoch.nees;
      ++nees_count_;
    }
    const WrongPoseLimits& limit = scenario_.wrong;
    const auto is_wrong = [&](double size, double sigma, double tolerated) {
      return size > limit.sigmas * sigma && size > tolerated;
    };
    const bool known = record.known_target;
    const double range = record.state.t_CT.norm();
    // The estimate of an unknown target's motion counts once its start is over.
    if (!known && record.mode != app::Mode::track) return;
    const bool wrong = is_wrong(epoch.attitude.norm(), std::sqrt(variance.tail<3>().sum()), limit.attitude_rad) ||
                       (known && is_wrong(epoch.position.norm(), std::sqrt(variance.head<3>().sum()),
                                          limit.position_of_range * range));
    if (!wrong) return;
    if (wrong_ == 0) first_wrong_ = epoch.time;
    ++wrong_;
  }

  const SimulationScenario& scenario_;
  Vec6 squares_ = Vec6::Zero();
  Vec6 variances_ = Vec6::Zero();
  double attitude_squares_ = 0.0, attitude_max_ = 0.0, attitude_last_ = 0.0;
  double position_squares_ = 0.0, position_max_ = 0.0;
  double rate_sum_ = 0.0, rate_max_ = 0.0;
  double angle_error_ = 0.0;
  bool has_angle_ = false;
  std::size_t count_ = 0, rates_ = 0, wrong_ = 0;
  Time first_wrong_;
  double nees_sum_ = 0.0;
  std::size_t nees_count_ = 0;
};

RunEnd end_of(const RunVerdict& verdict, const ReplayOutcome& outcome, const RunHistory& history) {
  if (verdict.poses == 0) return RunEnd::no_pose;
  if (verdict.wrong_poses > 0) return RunEnd::wrong_pose;
  if (!outcome.problem.empty()) return RunEnd::lost;
  return history.frames.back().reset_counter == 0 ? RunEnd::tracked : RunEnd::regained;
}

}  // namespace

const char* to_string(RunEnd end) {
  switch (end) {
    case RunEnd::tracked: return "tracked";
    case RunEnd::regained: return "regained";
    case RunEnd::lost: return "lost";
    case RunEnd::no_pose: return "no_pose";
    case RunEnd::wrong_pose: return "wrong_pose";
  }
  return "unknown";
}

bool known_at_end(const SimulationScenario& scenario) {
  const bool handed_over = scenario.handover.at_s >= 0.0;
  return (handed_over ? scenario.handover.navigation : scenario.navigation) != app::NavigationKind::noncoop;
}

AlignMode alignment_of(const RunHistory& track) {
  const bool known = !track.frames.empty() && track.frames.front().known_target;
  return known ? AlignMode::none : AlignMode::start;
}

RunHistory last_kind_of(const RunHistory& history) {
  RunHistory last;
  for (const FrameRecord& record : history.frames) {
    if (record.has_pose && record.known_target == history.frames.back().known_target) last.frames.push_back(record);
  }
  return last;
}

RunVerdict judge_run(const SimulationScenario& scenario, const ReplayOutcome& outcome, const RunHistory& history,
                     const Trajectory& truth) {
  RunVerdict verdict;
  verdict.problem = outcome.problem;
  verdict.frames = history.frames.size();
  verdict.poses = outcome.poses;
  verdict.nees_degrees_of_freedom = known_at_end(scenario) ? 6 : 3;
  Tally tally(scenario);
  for (const RunHistory& track : tracks_of(history)) {
    const auto evaluation = evaluate_run(track, truth, alignment_of(track));
    if (evaluation) tally.add(*evaluation, track);
  }
  tally.finish(verdict);
  const auto first =
      std::find_if(history.frames.begin(), history.frames.end(), [](const FrameRecord& r) { return r.has_pose; });
  if (first != history.frames.end())
    verdict.figures["first_pose_s"] = (first->time - history.frames.front().time).seconds();
  if (!history.frames.empty())
    verdict.figures["poses_percent"] =
        100.0 * static_cast<double>(outcome.poses) / static_cast<double>(history.frames.size());
  verdict.end = end_of(verdict, outcome, history);
  if (verdict.end == RunEnd::wrong_pose) {
    verdict.problem = format_text("%zu wrong poses called valid, the first at %.3f s", verdict.wrong_poses,
                                  (verdict.first_wrong - history.frames.front().time).seconds());
  }
  return verdict;
}

std::string result_json(const SimulationScenario& scenario, RunNumber run, const RunVerdict& verdict, double wall_s) {
  nlohmann::ordered_json json;
  json["scenario"] = scenario.name;
  json["scenario_crc"] = format_text("%08x", static_cast<unsigned>(scenario.crc));
  json["version"] = RELNAV_VERSION;
  json["run"] = run.number;
  json["seed"] = scenario.seed;
  json["outcome"] = to_string(verdict.end);
  json["problem"] = verdict.problem;
  json["frames"] = verdict.frames;
  json["poses"] = verdict.poses;
  json["invalid_flagged_valid"] = verdict.wrong_poses;
  json["figures"] = verdict.figures;
  json["nees"] = {{"sum", verdict.nees_sum}, {"count", verdict.nees_count}, {"dof", verdict.nees_degrees_of_freedom}};
  json["dispersed"] = scenario.dispersed;
  json["wall_s"] = wall_s;
  return json.dump() + "\n";
}

}  // namespace relnav::hil
