#pragma once
#include <string>

#include "fsw/app/flight_config.hpp"
#include "platform/files/camera_file.hpp"

namespace relnav {

/// What a flight loop is set up from: the contents of files, and where each was read, for messages.
struct FlightSetup {
  app::NavigationKind navigation = app::NavigationKind::noncoop;
  CameraCalibration camera;
  std::string camera_file;
  CameraCalibration second;  ///< coop_stereo
  std::string second_file;
  TargetModel target;  ///< coop_*
  std::string target_file;
  bool rigid_target = true;     ///< noncoop; else: moving camera
  double range_m = 0.0;         ///< start range, which also sets the scale; 0: the configuration's
  double range_sigma_m = -1.0;  ///< negative: the configuration's
  std::string config_file;      ///< of read_flight_config(); empty: defaults
};

/// What the flight loop is told by such a set-up. Throws InputError: unusable camera, target or configuration file.
[[nodiscard]] app::FlightLoopConfig flight_config_of(const FlightSetup& setup);

}  // namespace relnav
