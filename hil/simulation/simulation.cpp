#include "hil/simulation/simulation.hpp"

#include "hil/simulation/feature_driver.hpp"
#include "hil/simulation/scene_motion.hpp"
#include "hil/simulation/simulated_flight.hpp"
#include "platform/files/input_error.hpp"
#include "platform/files/text.hpp"

namespace relnav::hil {
namespace {

Time after_start(double seconds) { return Time{simulation_start_ns + static_cast<std::int64_t>(seconds * 1e9)}; }

}  // namespace

struct Simulation::Parts {
  std::vector<std::unique_ptr<ImageMaker>> makers;
  std::vector<std::unique_ptr<SimulatedCamera>> cameras;
  std::unique_ptr<SimulatedLines> lines;
  std::unique_ptr<SimulatedCommands> commands;
  std::unique_ptr<SimulatedFlight> flight;
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

StepDriver& Simulation::driver() {
  if (parts_->features) return *parts_->features;
  return *parts_->flight;
}

std::uint64_t Simulation::heartbeats() const { return parts_->lines ? parts_->lines->toggles() : 0; }

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
  std::vector<SimulatedCamera*> cameras;
  for (std::size_t c = 0; c < parts_->cameras.size(); ++c) {
    cameras.push_back(parts_->cameras[c].get());
    peripherals.exposures[c] = cameras[c];
  }
  wire(cameras, peripherals);
  hal::Camera* const second = cameras.size() > 1 ? cameras[1] : nullptr;
  auto loop = make_flight_driver(scenario_.flight, scenario_.path, clock_, *cameras[0], second, link, peripherals);
  parts_->flight = std::make_unique<SimulatedFlight>(std::move(loop), cameras, clock_);
  if (scenario_.handover.at_s < 0.0) return;
  app::FlightLoopConfig later = scenario_.flight;
  later.navigation = scenario_.handover.navigation;
  parts_->flight->plan({later, after_start(scenario_.handover.at_s)});
}

void Simulation::wire(const std::vector<SimulatedCamera*>& cameras, app::FlightPeripherals& peripherals) {
  if (scenario_.lines.any()) {
    std::vector<LineChange> pulses;
    if (scenario_.lines.pulse) {
      pulses = pulses_of(scenario_.lines, after_start(0.0), after_start(scenario_.duration_s), scenario_.seed);
    }
    parts_->lines = std::make_unique<SimulatedLines>(std::move(pulses), clock_);
    peripherals.lines = parts_->lines.get();
  }
  if (scenario_.lines.exposure) {
    const auto line = static_cast<std::uint32_t>(scenario_.flight.lines.exposure);
    cameras[0]->wire_exposures([this, line](Time begin, Time end) {
      parts_->lines->add({begin, line, true});
      parts_->lines->add({end, line, false});
    });
    for (std::size_t c = 1; c < cameras.size(); ++c) cameras[c]->wire_exposures([](Time, Time) {});
  }
  if (!scenario_.commands.empty()) {
    parts_->commands = std::make_unique<SimulatedCommands>(
        arrivals_of(scenario_.commands, scenario_.flight.packets, after_start(0.0)), clock_);
    peripherals.commands = parts_->commands.get();
  }
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
