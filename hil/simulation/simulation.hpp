#pragma once
#include <memory>
#include <vector>

#include "fsw/app/flight_peripherals.hpp"
#include "hal/packet_link.hpp"
#include "hil/replay/run_camera.hpp"
#include "hil/replay/step_driver.hpp"
#include "hil/simulation/image_maker.hpp"
#include "hil/simulation/simulated_capture.hpp"
#include "hil/simulation/simulated_clock.hpp"
#include "hil/simulation/simulation_plan.hpp"

namespace relnav::hil {

/// A scenario made ready to run: the flight loop with simulated cameras and clock behind its HAL, or, without images, the estimator
/// with simulated features. Drive it with run_replay().
class Simulation {
 public:
  /// `paced`: as fast as time goes. `makers`: for a scenario with images. `link`: where telemetry goes. Throws InputError.
  Simulation(const SimulationScenario& scenario, const ImageMakerFactory& makers, bool paced, hal::PacketLink& link);
  ~Simulation();
  Simulation(const Simulation&) = delete;
  Simulation& operator=(const Simulation&) = delete;

  [[nodiscard]] StepDriver& driver();
  [[nodiscard]] const RunCameras& cameras() const { return cameras_; }
  [[nodiscard]] const SimulationPlan& plan() const { return plan_; }
  /// Changes of the heartbeat line's level so far; 0 where there is none.
  [[nodiscard]] std::uint64_t heartbeats() const;
  /// Every frame goes into it, as the sensor gave it: without the scenario's faults. Before the run.
  void record_into(SimulatedCapture& capture) { capture_ = &capture; }

 private:
  struct Parts;
  void check_outside(std::size_t camera) const;
  void make_frame(std::size_t camera, std::size_t number, const hal::Exposure& exposure, Image& image);
  /// Lines and telecommands, as far as the scenario has them.
  void wire(const std::vector<SimulatedCamera*>& cameras, app::FlightPeripherals& peripherals);
  void set_up_images(const ImageMakerFactory& makers, hal::PacketLink& link);

  SimulationScenario scenario_;
  SimulationPlan plan_;
  SimulatedClock clock_;
  std::unique_ptr<Parts> parts_;
  RunCameras cameras_;
  SimulatedCapture* capture_ = nullptr;
};

}  // namespace relnav::hil
