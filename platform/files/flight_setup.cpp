#include "platform/files/flight_setup.hpp"

#include "platform/files/camera_rig_file.hpp"
#include "platform/files/flight_config_file.hpp"
#include "platform/files/input_error.hpp"

namespace relnav {
namespace {

void check_camera(const CameraIntrinsics& c, const std::string& file) {
  if (static_cast<std::size_t>(c.width_px) > config::max_image_width ||
      static_cast<std::size_t>(c.height_px) > config::max_image_height) {
    throw InputError(file, 0,
                     "resolution " + std::to_string(c.width_px) + " x " + std::to_string(c.height_px) +
                         " is larger than this build takes",
                     "at most " + std::to_string(config::max_image_width) + " x " +
                         std::to_string(config::max_image_height) + "; RELNAV_MAX_IMAGE_WIDTH and _HEIGHT set it");
  }
  if (!CameraModel::create(c))
    throw InputError(file, 0, "the camera model refuses these numbers", "a usable pinhole camera");
}

/// Fewer lights cannot be told from chance, and more take too long.
void check_target(const TargetModel& target, const std::string& file) {
  const std::size_t markers = target.features.size();
  if (markers >= app::CoopNavigatorConfig::least_markers && markers <= app::CoopNavigatorConfig::most_markers) return;
  throw InputError(file, 0, std::to_string(markers) + " features",
                   std::to_string(app::CoopNavigatorConfig::least_markers) + " to " +
                       std::to_string(app::CoopNavigatorConfig::most_markers) +
                       " where nobody says which light is which");
}

void set_up_cooperative(const FlightSetup& setup, app::FlightLoopConfig& config) {
  check_target(setup.target, setup.target_file);
  config.coop.target = setup.target;
  if (setup.navigation != app::NavigationKind::coop_stereo) return;
  check_camera(setup.second.intrinsics, setup.second_file);
  const CameraRig rig = camera_rig_of({setup.camera, setup.second}, {setup.camera_file, setup.second_file});
  config.second.intrinsics = setup.second.intrinsics;
  config.second.R_C1C0 = rig[1].R_KC;
  config.second.t_C1C0 = rig[1].t_KC;
}

}  // namespace

app::FlightLoopConfig flight_config_of(const FlightSetup& setup) {
  check_camera(setup.camera.intrinsics, setup.camera_file);
  auto config = app::FlightLoopConfig::defaults(setup.rigid_target ? MotionKind::rigid_target : MotionKind::camera);
  config.navigation = setup.navigation;
  config.camera = setup.camera.intrinsics;
  if (setup.navigation != app::NavigationKind::noncoop) set_up_cooperative(setup, config);
  if (!setup.config_file.empty()) read_flight_config(setup.config_file, config);
  if (setup.range_m > 0.0) config.navigator.filter.range_m = setup.range_m;
  if (setup.range_sigma_m >= 0.0) {
    config.navigator.filter.range_sigma_m = setup.range_sigma_m;
    config.scale_known = true;  // a range with its accuracy is a measured one
  }
  return config;
}

}  // namespace relnav
