#include "hil/replay/replay_run.hpp"

#include <algorithm>
#include <chrono>

namespace relnav::hil {
namespace {

constexpr std::size_t snapshot_count = 12;
constexpr int most_steps_without_frame = 100'000;

// Whether row `frame` of `listed` is one of the rows, spread evenly from first to last, to be shown.
bool is_snapshot(std::size_t frame, std::size_t listed) {
  if (listed <= snapshot_count) return true;
  const std::size_t intervals = snapshot_count - 1;
  const std::size_t k = (frame * intervals + (listed - 1) / 2) / (listed - 1);
  return (k * (listed - 1)) / intervals == frame;
}

// Of the camera whose frame the report is about.
Snapshot snapshot_of(const app::StepReport& report, const RunCamera& camera) {
  Snapshot s;
  s.time = camera.last_entry().time;
  s.frame = camera.frames_done() - 1;
  s.image = camera.last_entry();
  s.mode = report.mode;
  s.features.assign(report.feature_reports.begin(), report.feature_reports.end());
  return s;
}

bool are_finished(const RunCameras& cameras) {
  return std::all_of(cameras.begin(), cameras.end(), [](const RunCamera* c) { return c->finished(); });
}

std::size_t most(const RunCameras& cameras, std::size_t (RunCamera::*count)() const) {
  std::size_t most = 0;
  for (const RunCamera* camera : cameras) most = std::max(most, (camera->*count)());
  return most;
}

std::string problem_of(const RunCameras& cameras) {
  for (const RunCamera* camera : cameras) {
    if (!camera->problem().empty()) return camera->problem();
  }
  return {};
}

// The cameras that have got on in a step; the one that the report is about first.
RunCameras advanced_in(const app::StepReport& report, const RunCameras& cameras,
                       const std::vector<std::size_t>& done_before) {
  RunCameras advanced;
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    if (cameras[c]->frames_done() == done_before[c]) continue;
    advanced.insert(c == report.camera ? advanced.begin() : advanced.end(), cameras[c]);
  }
  return advanced;
}

// Whether the run ended well: tracking, or still in its first start with an estimate.
bool has_track(const RunHistory& history) {
  const FrameRecord& last = history.frames.back();
  return last.mode == app::Mode::track || (last.mode == app::Mode::acquire && last.has_pose && last.reset_counter == 0);
}

}  // namespace

ReplayOutcome run_replay(StepDriver& loop, const RunCameras& cameras, RunFiles* files, RunHistory& history,
                         const ProgressListener& listener) {
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
  const std::size_t listed = most(cameras, &RunCamera::frames_listed);
  while (!are_finished(cameras)) {
    std::vector<std::size_t> done_before;
    for (const RunCamera* camera : cameras) done_before.push_back(camera->frames_done());
    const app::StepReport& report = loop.step();
    outcome.last_mode = report.mode;
    const RunCameras advanced = advanced_in(report, cameras, done_before);
    const std::size_t done = most(cameras, &RunCamera::frames_done);
    if (!advanced.empty()) {
      idle_steps = 0;
      const RunCamera& camera = *advanced.front();
      const FrameRecord record = record_of(report, camera.last_entry().time);
      if (files != nullptr) files->add(record);
      history.frames.push_back(record);
      if (record.has_pose) ++outcome.poses;
      if (report.status == Status::ok && is_snapshot(camera.frames_done() - 1, camera.frames_listed())) {
        history.snapshots.push_back(snapshot_of(report, camera));
      }
      outcome.problem = problem_of(cameras);
      if (!outcome.problem.empty()) {
        outcome.end = End::bad_image;
        break;
      }
    } else if (++idle_steps > most_steps_without_frame) {
      // At real pace there may be nothing to do for a while; a wait then takes time, so this many never come.
      outcome.end = End::stuck;
      outcome.problem = std::string("the flight loop takes no more frames (") + to_string(report.status) + ")";
      break;
    }
    if (!listener(done, listed, report)) {
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
