#include "hil/simulation/simulation.hpp"

#include "hil/replay/flight_driver.hpp"
#include "hil/simulation/feature_driver.hpp"
#include "hil/simulation/scene_motion.hpp"
#include "platform/files/input_error.hpp"
#include "platform/files/text.hpp"

namespace relnav::hil {
namespace {

/// Stops the loop, gives it the other kind of navigation and starts it again, as a ground command would.
class HandoverDriver final : public StepDriver {
 public:
  HandoverDriver(std::unique_ptr<FlightDriver> flight, const app::FlightLoopConfig& later, Time when,
                 const SimulatedClock& clock)
      : flight_(std::move(flight)), later_(later), when_(when), clock_(clock) {}

  Status start() override { return flight_->start(); }
  const app::StepReport& step() override {
    if (!done_ && clock_.simulated() >= when_) hand_over();
    return flight_->step();
  }

 private:
  void hand_over() {
    done_ = true;
    Status status = flight_->stop();
    if (status == Status::ok) status = flight_->configure(later_);
    if (status == Status::ok) status = flight_->start();
    if (status != Status::ok) throw std::runtime_error(std::string("the hand-over failed: ") + to_string(status));
  }

  std::unique_ptr<FlightDriver> flight_;
  app::FlightLoopConfig later_;
  Time when_;
  const SimulatedClock& clock_;
  bool done_ = false;
};

}  // namespace

struct Simulation::Parts {
  std::vector<std::unique_ptr<ImageMaker>> makers;
  std::vector<std::unique_ptr<SimulatedCamera>> cameras;
  std::unique_ptr<StepDriver> flight;
  std::unique_ptr<FeatureDriver> features;
};

Simulation::Simulation(const SimulationScenario& scenario, const ImageMakerFactory& makers, bool paced,
                       hal::PacketLink& link)
    : scenario_(scenario),
      plan_(plan_simulation(scenario)),
      clock_(Time{simulation_start_ns}, paced),
      parts_(std::make_unique<Parts>()) {
  if (scenario_.sensor == SensorKind::images) {
    set_up_images(makers, link);
    return;
  }

  parts_->features =
      make_feature_driver(scenario_, plan_.true_rig, plan_.told_rig, plan_.frames, plan_.truth, clock_, link);
  cameras_ = {parts_->features.get()};
}

Simulation::~Simulation() = default;

StepDriver& Simulation::driver() { return parts_->features ? *parts_->features : *parts_->flight; }

void Simulation::set_up_images(const ImageMakerFactory& makers, hal::PacketLink& link) {
  if (!makers) {
    throw InputError(scenario_.path, 0, "this build of relnav renders no images",
                     "sensor: features, or a build with Embree and Assimp");
  }
  const hal::Exposure exposure{Duration{static_cast<std::int64_t>(scenario_.exposure_s * 1e9)}, scenario_.gain};
  for (std::size_t c = 0; c < plan_.true_rig.size(); ++c) {
    parts_->makers.push_back(makers(scenario_, plan_.true_rig[c].model, scenario_.seed + c));
    check_outside(c);
    // A fault hits the first camera; a pair goes on with the other.
    parts_->cameras.push_back(std::make_unique<SimulatedCamera>(
        plan_.frames, c == 0 ? scenario_.faults : std::vector<Fault>(), clock_,
        [this, c](std::size_t number, const hal::Exposure& e, Image& image) { make_frame(c, number, e, image); },
        exposure));
    cameras_.push_back(parts_->cameras.back().get());
  }
  app::FlightPeripherals peripherals;
  for (std::size_t c = 0; c < parts_->cameras.size(); ++c) peripherals.exposures[c] = parts_->cameras[c].get();
  hal::Camera* const second = parts_->cameras.size() > 1 ? parts_->cameras[1].get() : nullptr;
  auto flight =
      make_flight_driver(scenario_.flight, scenario_.path, clock_, *parts_->cameras[0], second, link, peripherals);
  if (scenario_.handover.at_s < 0.0) {
    parts_->flight = std::move(flight);
    return;
  }
  app::FlightLoopConfig later = scenario_.flight;
  later.navigation = scenario_.handover.navigation;
  const Time when{simulation_start_ns + static_cast<std::int64_t>(scenario_.handover.at_s * 1e9)};
  parts_->flight = std::make_unique<HandoverDriver>(std::move(flight), later, when, clock_);
}

void Simulation::check_outside(std::size_t camera) const {
  for (const SceneState& truth : plan_.truth) {
    if (!parts_->makers[camera]->is_inside(seen_by(plan_.true_rig[camera], truth))) continue;
    throw InputError(scenario_.path, 0,
                     format_text("camera %zu is inside of the target's mesh after %.3f s", camera,
                                 (truth.time - Time{simulation_start_ns}).seconds()),
                     "a way that stays outside");
  }
}

void Simulation::make_frame(std::size_t camera, std::size_t number, const hal::Exposure& exposure, Image& image) {
  const SceneState state = seen_by(plan_.true_rig[camera], plan_.truth[number]);
  parts_->makers[camera]->make(state, static_cast<std::uint32_t>(number), exposure, image);
  if (capture_ != nullptr) capture_->add(camera, plan_.frames[number].stamp, image);
}

}  // namespace relnav::hil
