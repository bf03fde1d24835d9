#include "hil/simulation/simulated_flight.hpp"

#include <stdexcept>
#include <string>

namespace relnav::hil {

const app::StepReport& SimulatedFlight::step() {
  if (handover_ && clock_.simulated() >= handover_->when) hand_over();
  const app::StepReport& report = flight_->step();
  if (report.mode == app::Mode::standby) {
    for (SimulatedCamera* camera : cameras_) camera->let_pass();
  }
  return report;
}

void SimulatedFlight::hand_over() {
  Status status = flight_->stop();
  if (status == Status::ok) status = flight_->configure(handover_->config);
  if (status == Status::ok) status = flight_->start();
  if (status != Status::ok) throw std::runtime_error(std::string("the hand-over failed: ") + to_string(status));
  handover_.reset();
}

}  // namespace relnav::hil
