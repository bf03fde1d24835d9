#include "hil/simulation/feature_driver.hpp"

#include <stdexcept>

#include "fsw/app/stage_timer.hpp"
#include "fsw/math/chi_square.hpp"
#include "platform/files/input_error.hpp"

namespace relnav::hil {
namespace {

class UnknownTargetDriver final : public FeatureDriver {
 public:
  UnknownTargetDriver(const SimulationScenario& scenario, const CameraModel& true_camera,
                      const CameraModel& told_camera, std::vector<PlannedFrame> frames, std::vector<SceneState> truth,
                      hal::Clock& clock, hal::PacketLink& link)
      : FeatureDriver(std::move(frames), std::move(truth), scenario.flight, link),
        clock_(clock),
        sensor_(scenario.features, true_camera, scenario.seed) {
    watch_.configure(scenario.flight.filter);
    if (filter_.configure(scenario.flight.navigator.filter, told_camera) != Status::ok)
      throw InputError(scenario.path, 0, "the filter refuses its configuration", "values inside their domains");
  }

 private:
  Status process(Time stamp, const SceneState& truth, app::StepReport& report) override {
    app::StageTimer timer(clock_);
    report.estimator = telemetry::Estimator::inverse_depth_ekf;
    if (!started_) {
      const Status status = sensor_.start(filter_, stamp, truth, config().navigator.min_start_features);
      report.times.detect_ns = timer.lap();
      if (status != Status::ok) return status;
      started_ = true;
      watch_.restart();
      fill(report);
      return Status::ok;
    }
    const Status predicted = filter_.predict(stamp);
    if (predicted != Status::ok) return predicted;
    filter_.predict_features(predictions_);
    report.times.predict_ns = timer.lap();
    sensor_.measure(predictions_, truth, matches_);
    report.times.match_ns = timer.lap();
    const FilterUpdate update = filter_.update(matches_);
    report.times.update_ns = timer.lap();
    report.matched = static_cast<std::uint16_t>(matches_.size());
    report.inliers = static_cast<std::uint16_t>(update.inliers);
    report.test_ratio = update.rows > 0 ? update.nis / chi2_99(update.rows) : 0.0;
    dropped_.clear();
    filter_.drop_spent_features(dropped_);
    for (const SlotHandle slot : dropped_) sensor_.forget(slot);
    sensor_.add_features(filter_, truth);
    report.times.detect_ns = timer.lap();
    fill(report);
    const Status verdict = watch_.judge(app::check_variances(filter_.state()), report.state,
                                        {update.status, report.test_ratio, is_starting()});
    return verdict == Status::ok ? update.status : verdict;
  }
  void fill(app::StepReport& report) {
    report.state = filter_.output();
    report.features = static_cast<std::uint16_t>(filter_.state().features().size());
  }
  void restart() override { started_ = false; }
  [[nodiscard]] bool has_started() const override { return started_; }
  [[nodiscard]] bool is_starting() const override { return filter_.is_starting(); }
  [[nodiscard]] bool predicts() const override { return true; }

  hal::Clock& clock_;
  SurfaceSensor sensor_;
  NoncoopFilter filter_;
  app::FilterWatch watch_;
  FeaturePredictions predictions_;
  FeatureMatches matches_;
  BoundedVector<SlotHandle, config::max_features> dropped_;
  bool started_ = false;
};

class KnownTargetDriver final : public FeatureDriver {
 public:
  KnownTargetDriver(const SimulationScenario& scenario, const CameraRig& true_rig, const CameraRig& told_rig,
                    std::vector<PlannedFrame> frames, std::vector<SceneState> truth, hal::PacketLink& link)
      : FeatureDriver(std::move(frames), std::move(truth), scenario.flight, link),
        sensor_(scenario.features, true_rig, scenario.target, scenario.seed),
        solver_({}, told_rig, scenario.target) {}

 private:
  Status process(Time stamp, const SceneState& truth, app::StepReport& report) override {
    const std::uint32_t resets = report.reset_counter;
    const app::Mode mode = report.mode;
    report = solver_.solve(stamp, sensor_.observe(truth));
    report.reset_counter = resets;
    report.mode = mode;
    started_ = started_ || report.status == Status::ok;
    return report.status;
  }
  void restart() override { started_ = false; }
  [[nodiscard]] bool has_started() const override { return started_; }
  [[nodiscard]] bool is_starting() const override { return false; }
  [[nodiscard]] bool predicts() const override { return false; }

  LightSensor sensor_;
  EpochSolver solver_;
  bool started_ = false;
};

}  // namespace

FeatureDriver::FeatureDriver(std::vector<PlannedFrame> frames, std::vector<SceneState> truth,
                             const app::FlightLoopConfig& config, hal::PacketLink& link)
    : frames_(std::move(frames)),
      truth_(std::move(truth)),
      config_(config),
      telemetry_(std::make_unique<app::TelemetryWriter>(link)) {
  if (telemetry_->configure(config_.packets, config_.event_spacing_frames) != Status::ok)
    throw std::runtime_error("the telemetry refuses its configuration");
}

Status FeatureDriver::start() {
  change_mode(app::Mode::acquire, Status::ok, {frames_.empty() ? Time{} : frames_[0].stamp, 0});
  return Status::ok;
}

void FeatureDriver::change_mode(app::Mode to, Status reason, const app::FrameStamp& stamp) {
  const app::Mode from = report_.mode;
  report_.mode = to;
  telemetry_->send_event(telemetry::EventId::mode_changed, reason, stamp, stamp.sequence,
                         {static_cast<std::int64_t>(from), static_cast<std::int64_t>(to)});
}

void FeatureDriver::give_up(Status reason, const app::FrameStamp& stamp) {
  restart();
  ++report_.reset_counter;
  without_update_ = 0;
  telemetry_->send_event(telemetry::EventId::track_lost, reason, stamp, stamp.sequence);
  change_mode(app::Mode::lost, reason, stamp);
}

const app::StepReport& FeatureDriver::step() {
  const std::size_t number = next_++;
  const app::FrameStamp stamp{frames_[number].stamp, static_cast<std::uint32_t>(number)};
  last_.time = stamp.time;
  const bool was_started = has_started();
  const app::Mode mode = report_.mode;
  const std::uint32_t resets = report_.reset_counter;
  const std::uint16_t refused = report_.refused_updates;
  report_ = {};
  report_.mode = mode;
  report_.reset_counter = resets;
  report_.refused_updates = refused;
  report_.status = process(stamp.time, truth_[number], report_);
  report_.processed = true;
  const app::StageTimes& t = report_.times;
  if (t.total_ns == 0) report_.times.total_ns = t.predict_ns + t.match_ns + t.update_ns + t.detect_ns;
  judge(was_started, stamp);
  telemetry_->send_state(report_, stamp, {report_.status == Status::ok, config_.is_scale_known(), report_.predicted});
  return report_;
}

void FeatureDriver::judge(bool was_started, const app::FrameStamp& stamp) {
  const Status status = report_.status;
  if (!has_started()) return;
  if (!was_started && report_.mode == app::Mode::lost) change_mode(app::Mode::acquire, Status::ok, stamp);
  const bool broken =
      status == Status::not_finite || status == Status::not_positive_definite || status == Status::no_convergence;
  if (broken && predicts()) return give_up(status, stamp);
  if (status != Status::ok && predicts()) {
    // The update was refused: the state is the predicted one, and valid as such.
    if (report_.refused_updates < UINT16_MAX) ++report_.refused_updates;
    report_.status = Status::ok;
    report_.predicted = true;
  }
  if (!was_started) return;
  if (status != Status::ok || report_.inliers < config_.min_inliers) {
    if (++without_update_ >= config_.lost_after_frames) give_up(Status::too_few_features, stamp);
    return;
  }
  without_update_ = 0;
  if (report_.mode != app::Mode::acquire || is_starting()) return;
  change_mode(app::Mode::track, Status::ok, stamp);
  telemetry_->send_event(telemetry::EventId::track_acquired, Status::ok, stamp, stamp.sequence, {report_.features});
}

std::unique_ptr<FeatureDriver> make_feature_driver(const SimulationScenario& scenario, const CameraRig& true_rig,
                                                   const CameraRig& told_rig, std::vector<PlannedFrame> frames,
                                                   std::vector<SceneState> truth, hal::Clock& clock,
                                                   hal::PacketLink& link) {
  if (scenario.navigation == app::NavigationKind::noncoop) {
    return std::make_unique<UnknownTargetDriver>(scenario, true_rig[0].model, told_rig[0].model, std::move(frames),
                                                 std::move(truth), clock, link);
  }
  return std::make_unique<KnownTargetDriver>(scenario, true_rig, told_rig, std::move(frames), std::move(truth), link);
}

}  // namespace relnav::hil
