#pragma once
#include <ostream>
#include <string>
#include <vector>

#include "fsw/base/time.hpp"
#include "fsw/math/types.hpp"

namespace relnav::hil {

/// Pose of target frame T in camera frame C at an instant: p_C = R_CT p_T + t_CT.
struct TimedPose {
  Time time;
  Vec3 t_CT = Vec3::Zero();
  Mat3 R_CT = Mat3::Identity();
};
using Trajectory = std::vector<TimedPose>;

/// TUM file, `t tx ty tz qx qy qz qw` a line. Throws InputError unless it holds at least one pose, numbers are finite,
/// quaternions have unit length within 1 % (they are normalised) and times strictly increase.
[[nodiscard]] Trajectory read_trajectory(const std::string& path);

/// One TUM line: t with nine decimals from the integer nanoseconds, quaternion with w >= 0.
[[nodiscard]] std::string trajectory_line(const TimedPose& pose);
inline constexpr const char* trajectory_header =
    "# t tx ty tz qx qy qz qw : pose of the target in the camera, p_C = R(q) p_T + t, s and m";

}  // namespace relnav::hil
