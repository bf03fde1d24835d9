#pragma once
#include <string>
#include <vector>

#include "fsw/geometry/camera_rig.hpp"
#include "platform/files/camera_file.hpp"

namespace relnav {

/// The rig of cameras with the same chaser body, in the order given; each T_BC says where a camera stands. `names` (one
/// a camera) are for messages. Throws InputError when there are more than config::max_cameras, or none, one cannot be
/// a CameraModel, or one stands where the first does.
[[nodiscard]] CameraRig camera_rig_of(const std::vector<CameraCalibration>& cameras,
                                      const std::vector<std::string>& names);

/// Camera files in the order of their numbers; a Kalibr camchain may be named once for each of its cameras.
[[nodiscard]] CameraRig read_camera_rig(const std::vector<std::string>& paths);

/// The text of an EuRoC sensor.yaml that reads back as this calibration.
[[nodiscard]] std::string camera_file_text(const CameraCalibration& camera);

}  // namespace relnav
