#include "hil/replay/replay_run.hpp"

#include <chrono>

namespace relnav::hil {
namespace {

constexpr std::size_t snapshot_count = 12;
constexpr int most_steps_without_frame = 100'000;

FrameRecord record_of(const app::StepReport& report, Time time) {
  FrameRecord r;
  r.time = time;
  r.status = report.status;
  r.mode = report.mode;
  r.has_pose = report.status == Status::ok && report.state.t_CT.allFinite() && report.state.R_CT.allFinite();
  r.state = report.state;
  r.reset_counter = report.reset_counter;
  r.features = report.features;
  r.matched = report.matched;
  r.inliers = report.inliers;
  r.refused_updates = report.refused_updates;
  r.test_ratio = report.test_ratio;
  r.times = report.times;
  return r;
}

// Whether row `frame` of `listed` is one of the rows, spread evenly from first to last, to be shown.
bool is_snapshot(std::size_t frame, std::size_t listed) {
  if (listed <= snapshot_count) return true;
  const std::size_t intervals = snapshot_count - 1;
  const std::size_t k = (frame * intervals + (listed - 1) / 2) / (listed - 1);
  return (k * (listed - 1)) / intervals == frame;
}

Snapshot snapshot_of(const app::StepReport& report, const ReplayCamera& camera) {
  Snapshot s;
  s.time = camera.last_entry().time;
  s.frame = camera.frames_consumed() - 1;
  s.image_path = camera.last_entry().path;
  s.mode = report.mode;
  s.features.assign(report.feature_reports.begin(), report.feature_reports.end());
  return s;
}

// Whether the run ended well: tracking, or still in its first start with an estimate.
bool has_track(const RunHistory& history) {
  const FrameRecord& last = history.frames.back();
  return last.mode == app::Mode::track || (last.mode == app::Mode::acquire && last.has_pose && last.reset_counter == 0);
}

}  // namespace

ReplayOutcome run_replay(StepDriver& loop, ReplayCamera& camera, const ReplayCamera* second, RunFiles& files,
                         RunHistory& history, const ProgressListener& listener) {
  using End = ReplayOutcome::End;
  ReplayOutcome outcome;
  const auto begin = std::chrono::steady_clock::now();
  const Status started = loop.start();
  if (started != Status::ok) {
    outcome.end = End::not_started;
    outcome.problem = std::string("the flight loop did not start: ") + to_string(started);
    return outcome;
  }
  int idle_steps = 0;
  while (!camera.exhausted()) {
    const std::size_t before = camera.frames_consumed();
    const app::StepReport& report = loop.step();
    outcome.last_mode = report.mode;
    if (camera.frames_consumed() == before) {
      if (!listener(before, camera.frames_listed(), report)) {
        outcome.end = End::interrupted;
        break;
      }
      // At real pace there may be nothing to do for a while; a wait then takes time, so this many never come.
      if (++idle_steps > most_steps_without_frame) {
        outcome.end = End::stuck;
        outcome.problem = std::string("the flight loop takes no more frames (") + to_string(report.status) + ")";
        break;
      }
      continue;
    }
    idle_steps = 0;
    const FrameRecord record = record_of(report, camera.last_entry().time);
    files.add(record);
    history.frames.push_back(record);
    if (record.has_pose) ++outcome.poses;
    if (report.status == Status::ok && is_snapshot(camera.frames_consumed() - 1, camera.frames_listed())) {
      history.snapshots.push_back(snapshot_of(report, camera));
    }
    const std::string& problem = camera.problem().empty() && second != nullptr ? second->problem() : camera.problem();
    if (!problem.empty()) {
      outcome.end = End::bad_image;
      outcome.problem = problem;
      break;
    }
    if (!listener(camera.frames_consumed(), camera.frames_listed(), report)) {
      outcome.end = End::interrupted;
      break;
    }
  }
  outcome.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  if (outcome.end == End::interrupted) outcome.problem = "interrupted";
  if (outcome.end == End::all_frames && outcome.poses == 0) {
    outcome.problem = "no pose was estimated";
  } else if (outcome.end == End::all_frames && !has_track(history)) {
    outcome.problem = std::string("the run ended without track, in mode ") + app::to_string(outcome.last_mode);
  }
  return outcome;
}

int exit_status_of(const ReplayOutcome& outcome) {
  if (outcome.end == ReplayOutcome::End::bad_image) return 2;
  return outcome.problem.empty() ? 0 : 1;
}

}  // namespace relnav::hil
