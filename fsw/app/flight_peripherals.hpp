#pragma once
#include "hal/command_source.hpp"
#include "hal/gpio_lines.hpp"

namespace relnav::app {

/// What a flight loop may have besides cameras, clock, link and watchdog; null where there is none.
struct FlightPeripherals {
  hal::GpioLines* lines = nullptr;
  hal::CommandSource* commands = nullptr;
};

}  // namespace relnav::app
