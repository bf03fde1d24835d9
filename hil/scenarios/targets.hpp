#pragma once
#include <vector>

#include "fsw/geometry/target_model.hpp"
#include "hil/io/trajectory.hpp"

namespace relnav::hil {

/// Vertices of a cube around the origin of T, ids 0 .. 7: bit 0, 1, 2 of the id set means x, y, z positive. Without
/// normals, since a vertex belongs to three faces.
[[nodiscard]] TargetModel cube_target(double edge_m);

/// Vertices of the cube (positions in the model) of which at least one face is turned to the camera of the pose.
[[nodiscard]] std::vector<std::size_t> visible_cube_vertices(double edge_m, const TimedPose& pose);

/// A, B, C, D (ids 0 .. 3) of a square in the x-y plane of T, x toward C, y toward D, with the lines AB, BC, CD.
[[nodiscard]] TargetModel square_target(double half_diagonal_m);

/// Eight points (ids 0 .. 7) in a sphere of 1 m radius, no four in a plane, no symmetry; seen from everywhere.
[[nodiscard]] TargetModel eight_point_target();

/// Every position in a model.
[[nodiscard]] std::vector<std::size_t> all_features(const TargetModel& target);

}  // namespace relnav::hil
