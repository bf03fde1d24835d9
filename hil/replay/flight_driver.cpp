#include "hil/replay/flight_driver.hpp"

#include "fsw/app/flight_loop.hpp"
#include "platform/files/input_error.hpp"
#include "platform/host/steady_clock.hpp"

namespace relnav::hil {
namespace {

/// A replay has nothing to be made safe.
class NoWatchdog final : public hal::Watchdog {
 public:
  Status kick() override { return Status::ok; }
  Status trip() override { return Status::ok; }
};

class FlightDriver final : public StepDriver {
 public:
  FlightDriver(hal::Camera& camera, hal::Camera* second, hal::PacketLink& link)
      : loop_(camera, clock_, link, watchdog_, second) {}
  Status configure(const app::FlightLoopConfig& config) { return loop_.configure(config); }
  Status start() override { return loop_.start(); }
  const app::StepReport& step() override { return loop_.step(); }

 private:
  platform::host::SteadyClock clock_;
  NoWatchdog watchdog_;
  app::FlightLoop loop_;
};

}  // namespace

std::unique_ptr<StepDriver> make_flight_driver(const FlightSetup& setup, hal::Camera& camera, hal::Camera* second,
                                               hal::PacketLink& link) {
  auto driver = std::make_unique<FlightDriver>(camera, second, link);
  const Status status = driver->configure(flight_config_of(setup));
  if (status != Status::ok) {
    throw InputError(setup.config_file.empty() ? setup.camera_file : setup.config_file, 0,
                     std::string("the flight loop refuses the configuration: ") + to_string(status),
                     "values inside their domains");
  }
  return driver;
}

}  // namespace relnav::hil
