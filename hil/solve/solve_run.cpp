#include "hil/solve/solve_run.hpp"

#include <chrono>
#include <cmath>
#include <memory>
#include <stdexcept>

#include "fsw/app/telemetry_writer.hpp"

namespace relnav::hil {
namespace {

/// Why an epoch has no valid pose; the same events as the flight loop's.
void send_failure(app::TelemetryWriter& telemetry, const app::StepReport& report, const app::FrameStamp& stamp) {
  using telemetry::EventId;
  EventId event = EventId::numerical_fault;
  app::EventArgs args{};
  if (report.status == Status::too_few_features) {
    event = EventId::too_few_features;
    args = {report.matched, 3};
  } else if (report.status == Status::ambiguous) {
    event = EventId::pose_ambiguous;
    args = {report.matched};
  } else if (report.status == Status::inconsistent) {
    event = EventId::update_refused;
    args = {std::llround(1e3 * report.test_ratio), report.matched, report.inliers};
  }
  telemetry.send_event(event, report.status, stamp, stamp.sequence, args);
}

}  // namespace

ReplayOutcome run_solve(const SolveSetup& setup, const CameraRig& rig, const TargetModel& target,
                        const std::string& observation_file, const std::vector<ObservationEpoch>& epochs,
                        hal::PacketLink& link, RunFiles& files, RunHistory& history, const ProgressListener& listener) {
  ReplayOutcome outcome;
  const auto begin = std::chrono::steady_clock::now();
  EpochSolver solver(setup, rig, target);
  const auto telemetry = std::make_unique<app::TelemetryWriter>(link);
  if (telemetry->configure(telemetry::PacketConfig{}, 0) != Status::ok) throw std::logic_error("telemetry defaults");
  std::uint32_t sequence = 0;
  for (const ObservationEpoch& epoch : epochs) {
    const app::StepReport& report = solver.solve(epoch.time, pose_observations(observation_file, epoch, target, rig));
    const FrameRecord record = record_of(report, epoch.time);
    const app::FrameStamp stamp{epoch.time, sequence};
    if (!record.has_pose) send_failure(*telemetry, report, stamp);
    telemetry->send_state(report, stamp, {record.has_pose, true});
    ++sequence;
    files.add(record);
    history.frames.push_back(record);
    outcome.last_mode = report.mode;
    if (record.has_pose) ++outcome.poses;
    if (!listener(history.frames.size(), epochs.size(), report)) {
      outcome.end = ReplayOutcome::End::interrupted;
      outcome.problem = "interrupted";
      break;
    }
  }
  outcome.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  if (outcome.problem.empty() && outcome.poses == 0) outcome.problem = "no pose was estimated";
  if (outcome.problem.empty() && !history.frames.back().has_pose) {
    outcome.problem = std::string("the last epoch has no valid pose: ") + to_string(history.frames.back().status);
  }
  return outcome;
}

}  // namespace relnav::hil
