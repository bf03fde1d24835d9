#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "fsw/base/time.hpp"
#include "fsw/geometry/camera_rig.hpp"
#include "fsw/geometry/pose_observation.hpp"
#include "fsw/geometry/target_model.hpp"
#include "fsw/math/types.hpp"

namespace relnav::hil {

/// One row: a target feature seen by a camera.
struct ObservationRow {
  int cam = 0;  ///< position of the camera's file on the command line
  std::uint16_t feature_id = 0;
  Vec2 uv_px = Vec2::Zero();
  double sigma_px = 1.0;
  int line = 0;  ///< in the file
};

/// Everything seen at one instant; never without rows.
struct ObservationEpoch {
  Time time;
  std::vector<ObservationRow> rows;
};

/// CSV with the header line `t_ns,cam,feature_id,u,v` and optional `sigma` (columns in any order), sorted by time; `#`
/// begins a comment. Throws InputError: no header or a column missing, unknown or twice; no rows; numbers missing or
/// not finite; sigma not positive (`default_sigma_px`, > 0, stands for a missing column); a time that goes back; a feature twice in one camera and epoch.
[[nodiscard]] std::vector<ObservationEpoch> read_observations(const std::string& path, double default_sigma_px = 1.0);

/// The rows of an epoch against the target and the cameras. Throws InputError (with the row's line in `path`): a feature
/// the target does not have, a camera the rig does not have, a pixel outside of its image.
[[nodiscard]] PoseObservations pose_observations(const std::string& path, const ObservationEpoch& epoch,
                                                 const TargetModel& target, const CameraRig& rig);
/// The same for all epochs, to find what is wrong before anything is written; also a camera without any row.
void check_observations(const std::string& path, const std::vector<ObservationEpoch>& epochs, const TargetModel& target,
                        const CameraRig& rig);

inline constexpr const char* observation_header = "t_ns,cam,feature_id,u,v,sigma";
[[nodiscard]] std::string observation_line(Time time, const ObservationRow& row);

}  // namespace relnav::hil
