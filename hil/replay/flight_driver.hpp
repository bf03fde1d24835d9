#pragma once
#include <memory>
#include <string>

#include "fsw/app/flight_config.hpp"
#include "hal/camera.hpp"
#include "hal/packet_link.hpp"
#include "hil/io/camera_file.hpp"
#include "hil/replay/step_driver.hpp"

namespace relnav::hil {

/// How the flight loop is to be set up, as far as the command line says.
struct FlightSetup {
  app::NavigationKind navigation = app::NavigationKind::noncoop;
  CameraCalibration camera;
  std::string camera_file;   ///< where it was read, for messages
  CameraCalibration second;  ///< coop_stereo
  std::string second_file;
  TargetModel target;  ///< coop_*
  std::string target_file;
  bool rigid_target = true;     ///< noncoop; else: moving camera
  double range_m = 0.0;         ///< start range, which also sets the scale; 0: the configuration's
  double range_sigma_m = -1.0;  ///< negative: the configuration's
  std::string config_file;      ///< empty: defaults
};

/// What the flight loop is told by such a set-up. Throws InputError: unusable camera, target or configuration file.
[[nodiscard]] app::FlightLoopConfig flight_config_of(const FlightSetup& setup);

/// `second`: for coop_stereo, else null. The flight loop with a steady clock and a watchdog that does nothing. Throws InputError when the configuration is refused.
[[nodiscard]] std::unique_ptr<StepDriver> make_flight_driver(const FlightSetup& setup, hal::Camera& camera,
                                                             hal::Camera* second, hal::PacketLink& link);

}  // namespace relnav::hil
