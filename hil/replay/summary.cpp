#include "hil/replay/summary.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

namespace relnav::hil {

using Json = nlohmann::ordered_json;

std::optional<Evaluation> evaluate_run(const RunHistory& history, const Trajectory& truth, AlignMode align) {
  Trajectory estimate;
  std::vector<TimedCovariance> covariances;
  for (const FrameRecord& r : history.frames) {
    // Stamps that repeat or go back have no place in a trajectory; the flight loop refuses such frames.
    if (!r.has_pose || (!estimate.empty() && r.state.time <= estimate.back().time)) continue;
    estimate.push_back({r.state.time, r.state.t_CT, r.state.R_CT});
    covariances.push_back({r.state.time, r.state.pose_covariance});
  }
  if (estimate.empty() || truth.empty() || associate(truth, estimate).pairs.empty()) return std::nullopt;
  return evaluate(truth, estimate, &covariances, align);
}

TimeFigures time_figures(const RunHistory& history) {
  std::vector<double> us;
  for (const FrameRecord& r : history.frames) {
    if (r.status == Status::ok) us.push_back(static_cast<double>(r.times.total_ns - r.times.acquire_ns) * 1e-3);
  }
  if (us.empty()) return {};
  std::sort(us.begin(), us.end());
  return {us[us.size() / 2], us[us.size() * 95 / 100], us.back()};
}

std::string summary_json(const RunDescription& d, const ReplayOutcome& outcome, const RunHistory& history,
                         const Evaluation* evaluation) {
  Json json;
  json["dataset"] = d.dataset;
  json["mode"] = d.mode;
  if (!d.target.empty()) json["target"] = d.target;
  if (!d.method.empty()) json["method"] = d.method;
  if (!d.motion.empty()) {
    json["motion"] = d.motion;
    json["range_m"] = d.range_m;
    json["range_sigma_m"] = d.range_sigma_m;
  }
  if (!d.config.empty()) json["config"] = d.config;
  json["exit_status"] = exit_status_of(outcome);
  json["problem"] = outcome.problem.empty() ? Json(nullptr) : Json(outcome.problem);
  json["frames_listed"] = d.frames_listed;
  json["frames_seen"] = history.frames.size();
  json["poses"] = outcome.poses;
  json["frames_refused"] = std::count_if(history.frames.begin(), history.frames.end(),
                                         [](const FrameRecord& r) { return r.status != Status::ok; });
  json["last_mode"] = app::to_string(outcome.last_mode);
  double features = 0.0;
  double inliers = 0.0;
  for (const FrameRecord& r : history.frames) {
    features += r.features / static_cast<double>(history.frames.size());
    inliers += r.inliers / static_cast<double>(history.frames.size());
  }
  const bool any = !history.frames.empty();
  json["resets"] = any ? history.frames.back().reset_counter : 0;
  json["refused_updates"] = any ? history.frames.back().refused_updates : 0;
  json["mean_features"] = features;
  json["mean_inliers"] = inliers;
  const TimeFigures t = time_figures(history);
  json["step_us"] = {{"median", t.median_us}, {"p95", t.p95_us}, {"max", t.max_us}};
  json["wall_s"] = outcome.wall_s;
  json["frames_per_second"] = outcome.wall_s > 0.0 ? static_cast<double>(history.frames.size()) / outcome.wall_s : 0.0;
  if (evaluation != nullptr) json["evaluation"] = Json::parse(evaluation_json(*evaluation));
  return json.dump(2) + "\n";
}

}  // namespace relnav::hil
