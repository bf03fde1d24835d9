#include "hil/replay/flight_driver.hpp"

#include "platform/files/input_error.hpp"

namespace relnav::hil {

std::unique_ptr<FlightDriver> make_flight_driver(const app::FlightLoopConfig& config, const std::string& file,
                                                 hal::Clock& clock, hal::Camera& camera, hal::Camera* second,
                                                 hal::PacketLink& link, const app::FlightPeripherals& peripherals) {
  auto driver = std::make_unique<FlightDriver>(clock, camera, second, link, peripherals);
  const Status status = driver->configure(config);
  if (status != Status::ok) {
    throw InputError(file, 0, std::string("the flight loop refuses the configuration: ") + to_string(status),
                     "values inside their domains");
  }
  return driver;
}

}  // namespace relnav::hil
