#pragma once
#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "hal/clock.hpp"
#include "platform/linux/camera_driver.hpp"

namespace relnav::hil {

/// A real camera, as it is named and set up on the command line.
struct CameraChoice {
  std::string camera;  ///< v4l2:/dev/videoN or aravis:NAME
  platform::linux::CameraSettings settings;
  std::string trigger = "free-running";
  std::string stamps = "end-of-exposure";
  bool copy_frames = false;
};

void add_camera_options(CLI::App& command, CameraChoice& choice);

/// Completes `choice.settings` from the words. Throws InputError.
void interpret(CameraChoice& choice);

/// `clock`: CLOCK_MONOTONIC; outlives the driver. Throws InputError: a kind of camera that this build does without.
[[nodiscard]] std::unique_ptr<platform::linux::CameraDriver> make_camera_driver(const CameraChoice& choice,
                                                                                hal::Clock& clock);

}  // namespace relnav::hil
