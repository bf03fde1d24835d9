#pragma once
#include <array>
#include <cstdint>
#include <string>

#include "fsw/math/types.hpp"

namespace relnav::hil {

enum class DistortionModel { none, radial_tangential, radial_inverse, equidistant };

/// What a camera calibration file says. Distortion formulas: docs conventions.
struct CameraCalibration {
  double fu = 0.0, fv = 0.0, cu = 0.0, cv = 0.0;  ///< pixels
  DistortionModel distortion = DistortionModel::none;
  std::array<double, 4> coefficients{};  ///< unused ones are zero
  std::uint32_t width_px = 0;
  std::uint32_t height_px = 0;
  double rate_hz = 0.0;                           ///< 0: not stated
  Mat<4, 4> T_BC = Mat<4, 4>::Identity();         ///< camera to chaser body coordinates (key T_BS)
};

/// Reads an EuRoC sensor.yaml, a Kalibr camchain (node cam<index>), a ROS camera_info file or an OpenCV FileStorage file.
/// Throws InputError, with the line where one applies.
[[nodiscard]] CameraCalibration read_camera_file(const std::string& path, int index = 0);

}  // namespace relnav::hil
