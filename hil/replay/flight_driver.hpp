#pragma once
#include <memory>

#include "fsw/app/flight_loop.hpp"
#include "hil/replay/step_driver.hpp"
#include "platform/files/flight_setup.hpp"

namespace relnav::hil {

/// The flight loop, with a watchdog that does nothing: on a PC there is nothing to be made safe.
class FlightDriver final : public StepDriver {
 public:
  /// `second`: for coop_stereo, else null.
  FlightDriver(hal::Clock& clock, hal::Camera& camera, hal::Camera* second, hal::PacketLink& link,
               const app::FlightPeripherals& peripherals = {})
      : loop_(camera, clock, link, watchdog_, second, peripherals) {}

  Status configure(const app::FlightLoopConfig& config) { return loop_.configure(config); }
  Status start() override { return loop_.start(); }
  const app::StepReport& step() override { return loop_.step(); }
  Status stop() { return loop_.stop(); }

 private:
  class NoWatchdog final : public hal::Watchdog {
   public:
    Status kick() override { return Status::ok; }
    Status trip() override { return Status::ok; }
  };

  NoWatchdog watchdog_;
  app::FlightLoop loop_;
};

/// `file`: for the message. Throws InputError when the configuration is refused.
[[nodiscard]] std::unique_ptr<FlightDriver> make_flight_driver(const app::FlightLoopConfig& config,
                                                               const std::string& file, hal::Clock& clock,
                                                               hal::Camera& camera, hal::Camera* second,
                                                               hal::PacketLink& link,
                                                               const app::FlightPeripherals& peripherals = {});

}  // namespace relnav::hil
