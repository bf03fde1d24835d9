#pragma once
#include <memory>

#include "hal/camera.hpp"
#include "hal/packet_link.hpp"
#include "hil/replay/step_driver.hpp"
#include "platform/files/flight_setup.hpp"

namespace relnav::hil {

/// `second`: for coop_stereo, else null. The flight loop with a steady clock and a watchdog that does nothing. Throws InputError when the configuration is refused.
[[nodiscard]] std::unique_ptr<StepDriver> make_flight_driver(const FlightSetup& setup, hal::Camera& camera,
                                                             hal::Camera* second, hal::PacketLink& link);

}  // namespace relnav::hil
