#pragma once
#include <memory>
#include <vector>

#include "fsw/app/filter_watch.hpp"
#include "fsw/app/telemetry_writer.hpp"
#include "hal/clock.hpp"
#include "hal/packet_link.hpp"
#include "hil/replay/run_camera.hpp"
#include "hil/replay/step_driver.hpp"
#include "hil/simulation/feature_sensor.hpp"
#include "hil/simulation/simulated_camera.hpp"
#include "hil/solve/epoch_solver.hpp"

namespace relnav::hil {

/// Stands in for flight loop and camera where there are no images: each step observes the features of one frame and hands them to
/// the flight code's estimator. Modes, losses and telemetry follow the loop's rules.
class FeatureDriver : public StepDriver, public RunCamera {
 public:
  Status start() override;
  const app::StepReport& step() override;

  [[nodiscard]] std::size_t frames_listed() const override { return frames_.size(); }
  [[nodiscard]] std::size_t frames_done() const override { return next_; }
  [[nodiscard]] const ImageEntry& last_entry() const override { return last_; }
  [[nodiscard]] const std::string& problem() const override { return problem_; }

 protected:
  /// `truth`: one state a frame.
  FeatureDriver(std::vector<PlannedFrame> frames, std::vector<SceneState> truth, const app::FlightLoopConfig& config,
                hal::PacketLink& link);

  /// Status as FlightLoop::step(); fills state and counts of `report`.
  virtual Status process(Time stamp, const SceneState& truth, app::StepReport& report) = 0;
  /// The estimate is given up.
  virtual void restart() = 0;
  [[nodiscard]] virtual bool has_started() const = 0;
  [[nodiscard]] virtual bool is_starting() const = 0;
  /// Goes on by its prediction where an update is refused, and may break; else each frame stands by itself.
  [[nodiscard]] virtual bool predicts() const = 0;
  [[nodiscard]] const app::FlightLoopConfig& config() const { return config_; }

 private:
  void judge(bool was_started, const app::FrameStamp& stamp);
  void give_up(Status reason, const app::FrameStamp& stamp);
  void change_mode(app::Mode to, Status reason, const app::FrameStamp& stamp);

  std::vector<PlannedFrame> frames_;
  std::vector<SceneState> truth_;
  app::FlightLoopConfig config_;
  std::unique_ptr<app::TelemetryWriter> telemetry_;
  app::StepReport report_;
  ImageEntry last_;
  std::string problem_;
  std::size_t next_ = 0;
  std::uint16_t without_update_ = 0;
};

/// The driver for the scenario's navigation. Throws InputError: the estimator refuses the configuration.
[[nodiscard]] std::unique_ptr<FeatureDriver> make_feature_driver(const SimulationScenario& scenario,
                                                                 const CameraRig& true_rig, const CameraRig& told_rig,
                                                                 std::vector<PlannedFrame> frames,
                                                                 std::vector<SceneState> truth, hal::Clock& clock,
                                                                 hal::PacketLink& link);

}  // namespace relnav::hil
