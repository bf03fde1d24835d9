#pragma once
#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "hil/io/image_entry.hpp"
#include "hil/replay/flight_driver.hpp"
#include "hil/replay/replay_camera.hpp"

namespace relnav::hil {

/// What a flight loop over captured frames is told on the command line.
struct FlightOptions {
  std::string dataset;
  std::string mode;
  std::string target;
  std::string config;
  std::string motion;  ///< empty: rigid-target
  double range_m = 0.0;
  double range_sigma_m = -1.0;
};

void add_flight_options(CLI::App& command, FlightOptions& options);

/// Everything that the options name, read. Throws InputError.
struct FlightInput {
  FlightSetup setup;
  std::vector<ImageEntry> images;
  std::vector<ImageEntry> second_images;  ///< coop-stereo
  Depth depth = Depth::eight_bits;
};
/// What is left out of a damaged capture is said on stderr.
[[nodiscard]] FlightInput read_flight_input(const FlightOptions& options);

}  // namespace relnav::hil
