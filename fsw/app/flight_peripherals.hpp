#pragma once
#include <array>

#include "fsw/config.hpp"
#include "hal/command_source.hpp"
#include "hal/exposure_control.hpp"
#include "hal/gpio_lines.hpp"

namespace relnav::app {

/// What a flight loop may have besides cameras, clock, link and watchdog; null where there is none.
struct FlightPeripherals {
  hal::GpioLines* lines = nullptr;
  hal::CommandSource* commands = nullptr;
  std::array<hal::ExposureControl*, config::max_cameras> exposures{};  ///< of each camera
};

}  // namespace relnav::app
