#pragma once
#include <memory>
#include <vector>

#include "hil/replay/flight_driver.hpp"
#include "hil/simulation/simulated_camera.hpp"

namespace relnav::hil {

/// Another configuration of the flight from a moment on.
struct PlannedHandover {
  app::FlightLoopConfig config;
  Time when;
};

/// The flight loop in simulated time: while it stands by, time goes on all the same, and frames go by unseen.
class SimulatedFlight final : public StepDriver {
 public:
  SimulatedFlight(std::unique_ptr<FlightDriver> flight, std::vector<SimulatedCamera*> cameras, SimulatedClock& clock)
      : flight_(std::move(flight)), cameras_(std::move(cameras)), clock_(clock) {}

  /// The loop is stopped then, takes the other configuration and starts again, as a ground command would have it.
  void plan(const PlannedHandover& handover) { handover_ = std::make_unique<PlannedHandover>(handover); }

  Status start() override { return flight_->start(); }
  /// Throws std::runtime_error when the loop refuses the hand-over.
  const app::StepReport& step() override;

 private:
  void hand_over();

  std::unique_ptr<FlightDriver> flight_;
  std::vector<SimulatedCamera*> cameras_;
  SimulatedClock& clock_;
  std::unique_ptr<PlannedHandover> handover_;  ///< null: none, or done
};

}  // namespace relnav::hil
