#include "hil/io/trajectory.hpp"

#include <Eigen/Geometry>
#include <array>
#include <cmath>

#include "platform/files/input_error.hpp"
#include "platform/files/text.hpp"

namespace relnav::hil {
namespace {

TimedPose parse_pose(const std::string& path, int line, std::string_view text) {
  const auto words = split_words(text);
  if (words.size() != 8) {
    throw InputError(path, line, std::to_string(words.size()) + " values", "8 numbers: t tx ty tz qx qy qz qw");
  }
  const auto ns = parse_seconds_to_ns(words[0]);
  if (!ns) throw InputError(path, line, "time " + in_quotes(words[0]), "decimal seconds");
  std::array<double, 7> value{};
  for (std::size_t i = 0; i < value.size(); ++i) {
    const auto number = parse_double(words[i + 1]);
    if (!number || !std::isfinite(*number)) {
      throw InputError(path, line, "value " + in_quotes(words[i + 1]), "a finite number");
    }
    value[i] = *number;
  }
  Eigen::Quaterniond q_CT(value[6], value[3], value[4], value[5]);
  if (std::abs(q_CT.norm() - 1.0) > 0.01) {
    throw InputError(path, line, format_text("quaternion of length %.6g", q_CT.norm()),
                     "a unit quaternion qx qy qz qw");
  }
  q_CT.normalize();
  return {Time{*ns}, Vec3(value[0], value[1], value[2]), q_CT.toRotationMatrix()};
}

}  // namespace

Trajectory read_trajectory(const std::string& path) {
  Trajectory trajectory;
  int number = 0;
  for (const std::string& line : read_lines(path)) {
    ++number;
    const std::string_view text = trimmed(std::string_view(line).substr(0, line.find('#')));
    if (text.empty()) continue;
    const TimedPose pose = parse_pose(path, number, text);
    if (!trajectory.empty() && pose.time <= trajectory.back().time) {
      throw InputError(path, number,
                       "time " + format_seconds(pose.time.ns) + " after " + format_seconds(trajectory.back().time.ns),
                       "strictly increasing times");
    }
    trajectory.push_back(pose);
  }
  if (trajectory.empty()) throw InputError(path, 0, "holds no pose", "lines t tx ty tz qx qy qz qw");
  return trajectory;
}

std::string trajectory_line(const TimedPose& pose) {
  Eigen::Quaterniond q_CT(pose.R_CT);
  q_CT.normalize();
  if (q_CT.w() < 0.0) q_CT.coeffs() = -q_CT.coeffs();
  return format_seconds(pose.time.ns) + format_text(" %.9f %.9f %.9f %.12f %.12f %.12f %.12f", pose.t_CT.x(),
                                                    pose.t_CT.y(), pose.t_CT.z(), q_CT.x(), q_CT.y(), q_CT.z(),
                                                    q_CT.w());
}

}  // namespace relnav::hil
