#pragma once
#include <array>

#include "fsw/base/status.hpp"
#include "fsw/geometry/pose_observation.hpp"

namespace relnav {

/// Three points of a target and what the three-point problem needs of them, computed once.
struct P3pPoints {
  Vec3 p1_T = Vec3::Zero();  ///< m
  double a12 = 0.0;          ///< squared distances, m^2
  double a13 = 0.0;
  double a23 = 0.0;
  Mat3 basis_inverse = Mat3::Identity();  ///< of [p1 - p2 | p1 - p3 | their cross product]
};

/// rank_deficient: the points lie on a line (sine of the angle at the first one under 1e-3). not_finite.
Status make_p3p_points(const std::array<Vec3, 3>& p_T, P3pPoints& out);

/// Poses under which three points are seen along three rays: Persson, Nordberg, "Lambda Twist", ECCV 2018. `rays_C`: unit
/// length, in the order of the points. All points lie in front along their rays. Distances are polished by Newton steps, to
/// about 1e-12 except near double solutions; what does not come near the distances of the points is no solution. Only sqrt; at
/// most 20 + 2 x 4 Newton steps. Returns their number, 0 .. 4; coinciding solutions may come twice.
[[nodiscard]] int solve_p3p(const P3pPoints& points, const std::array<Vec3, 3>& rays_C, std::array<Pose, 4>& out);

}  // namespace relnav
