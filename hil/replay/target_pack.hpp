#pragma once
#include <string>
#include <vector>

#include "fsw/app/flight_config.hpp"
#include "hil/replay/replay_camera.hpp"

namespace relnav::hil {

/// setup.bin (fsw/app/config_image.hpp). Throws InputError.
void pack_config(const app::FlightLoopConfig& config, const std::string& path);

/// The images as a raw container, each as ReplayCamera gives it. Throws InputError: an image that cannot be used, or written.
void pack_frames(const std::vector<ImageEntry>& images, const CameraIntrinsics& camera, Depth depth,
                 const std::string& path);

}  // namespace relnav::hil
