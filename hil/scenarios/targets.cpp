#include "hil/scenarios/targets.hpp"

#include <array>
#include <stdexcept>

namespace relnav::hil {
namespace {

void add(TargetModel& target, const Vec3& p_T) {
  TargetFeature feature;
  feature.id = static_cast<std::uint16_t>(target.features.size());
  feature.p_T = p_T;
  if (target.features.push_back(feature) != Status::ok) throw std::length_error("target model is full");
}

double side_of(std::size_t vertex, std::size_t axis) { return ((vertex >> axis) & 1U) != 0 ? 1.0 : -1.0; }

}  // namespace

TargetModel cube_target(double edge_m) {
  TargetModel target;
  for (std::size_t vertex = 0; vertex < 8; ++vertex) {
    add(target, 0.5 * edge_m * Vec3(side_of(vertex, 0), side_of(vertex, 1), side_of(vertex, 2)));
  }
  return target;
}

std::vector<std::size_t> visible_cube_vertices(double edge_m, const TimedPose& pose) {
  const Vec3 camera_T = -(pose.R_CT.transpose() * pose.t_CT);
  std::vector<std::size_t> vertices;
  for (std::size_t vertex = 0; vertex < 8; ++vertex) {
    bool visible = false;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      visible = visible || side_of(vertex, axis) * camera_T(static_cast<Eigen::Index>(axis)) > 0.5 * edge_m;
    }
    if (visible) vertices.push_back(vertex);
  }
  return vertices;
}

TargetModel square_target(double half_diagonal_m) {
  TargetModel target;
  add(target, Vec3(-half_diagonal_m, 0.0, 0.0));
  add(target, Vec3(0.0, -half_diagonal_m, 0.0));
  add(target, Vec3(half_diagonal_m, 0.0, 0.0));
  add(target, Vec3(0.0, half_diagonal_m, 0.0));
  for (std::uint16_t i = 0; i < 3; ++i) {
    if (target.lines.push_back({i, static_cast<std::uint16_t>(i + 1)}) != Status::ok)
      throw std::length_error("target model is full");
  }
  return target;
}

TargetModel eight_point_target() {
  static constexpr std::array<std::array<double, 3>, 8> points{{{0.90, 0.10, -0.30},
                                                                {-0.70, 0.50, 0.40},
                                                                {0.20, -0.90, 0.20},
                                                                {-0.30, -0.40, -0.80},
                                                                {0.50, 0.60, 0.60},
                                                                {-0.80, -0.30, 0.10},
                                                                {0.10, 0.80, -0.50},
                                                                {0.40, -0.20, 0.85}}};
  TargetModel target;
  for (const auto& p : points) add(target, Vec3(p[0], p[1], p[2]));
  return target;
}

std::vector<std::size_t> all_features(const TargetModel& target) {
  std::vector<std::size_t> all;
  for (std::size_t i = 0; i < target.features.size(); ++i) all.push_back(i);
  return all;
}

}  // namespace relnav::hil
