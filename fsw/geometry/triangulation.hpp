#pragma once
#include <algorithm>

#include <Eigen/Core>

#include "fsw/base/status.hpp"
#include "fsw/math/normal_equations.hpp"

namespace relnav {

/// rad, about: rays closer than that to parallel do not meet. In units of the distance of the cameras a point is then nearer than
/// 2^16, in every scalar.
inline constexpr double least_parallax = 5e-5;

/// Point from its images in two cameras by linear least squares on the two projections: 4 equations, 3 unknowns (Chen, Chen,
/// Wang 2015, (1)). xy: normalised, undistorted image coordinates. First camera: C itself; second: p_2 = R_KC p_C + t_KC.
/// The unknowns are the depth z and the distance across from the first ray, p_C = (x_1, y_1, 1) z + (dx, dy, 0), with z in
/// units that make its column one: the same solution, but no difference of large numbers for what far away is a small angle
/// between the rays. rank_deficient: the two rays are parallel to within least_parallax.
template <typename S>
Status triangulate(const Eigen::Matrix<S, 2, 1>& xy_1, const Eigen::Matrix<S, 2, 1>& xy_2,
                   const Eigen::Matrix<S, 3, 3>& R_KC, const Eigen::Matrix<S, 3, 1>& t_KC,
                   Eigen::Matrix<S, 3, 1>& p_C) {
  Eigen::Matrix<S, 2, 3> across;  // of the second camera's equations
  S parallax(0);
  for (int k = 0; k < 2; ++k) {
    for (int c = 0; c < 3; ++c) across(k, c) = xy_2(k) * R_KC(2, c) - R_KC(k, c);
    across(k, 2) += across(k, 0) * xy_1(0) + across(k, 1) * xy_1(1);
    parallax = std::max(parallax, across(k, 2) < S(0) ? -across(k, 2) : across(k, 2));
  }
  if (!(parallax > S(least_parallax))) return Status::rank_deficient;
  const S unit = S(1) / parallax;
  NormalEquations<S, 3> equations;
  equations.clear();
  const S zero(0);
  equations.add({S(1), zero, zero}, zero);
  equations.add({zero, S(1), zero}, zero);
  for (int k = 0; k < 2; ++k) {
    equations.add({across(k, 0), across(k, 1), across(k, 2) * unit}, t_KC(k) - xy_2(k) * t_KC(2));
  }
  const Status status = equations.factorise(zero);
  if (status != Status::ok) return status;
  S gain;
  const Eigen::Matrix<S, 3, 1> d = equations.solution(gain);
  const S z = d(2) * unit;
  p_C = Eigen::Matrix<S, 3, 1>(xy_1(0) * z + d(0), xy_1(1) * z + d(1), z);
  return Status::ok;
}

}  // namespace relnav
