#pragma once
#include <string>

#include "fsw/geometry/camera_model.hpp"
#include "fsw/math/types.hpp"

namespace relnav {

/// What a camera calibration file says.
struct CameraCalibration {
  CameraIntrinsics intrinsics;
  double rate_hz = 0.0;                    ///< 0: not stated
  Mat<4, 4> T_BC = Mat<4, 4>::Identity();  ///< camera to chaser body coordinates (key T_BS)
};

/// Reads an EuRoC sensor.yaml, a Kalibr camchain (node cam<index>), a ROS camera_info file or an OpenCV FileStorage file.
/// Throws InputError, with the line where one applies.
[[nodiscard]] CameraCalibration read_camera_file(const std::string& path, int index = 0);

}  // namespace relnav
