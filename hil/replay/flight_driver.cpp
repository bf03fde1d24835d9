#include "hil/replay/flight_driver.hpp"

#include "hil/io/input_error.hpp"

namespace relnav::hil {

std::unique_ptr<StepDriver> make_flight_driver(const FlightSetup&, hal::Camera&, hal::PacketLink&) {
  throw InputError("replay", 0, "the flight loop is not in this build yet", "a build with fsw/app");
}

}  // namespace relnav::hil
