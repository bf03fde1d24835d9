#pragma once
#include <Eigen/Core>

#include "fsw/base/status.hpp"
#include "fsw/math/normal_equations.hpp"

namespace relnav {

/// Point from its images in two cameras by linear least squares on the two projections: 4 equations, 3 unknowns (Chen, Chen,
/// Wang 2015, (1)). xy: normalised, undistorted image coordinates. First camera: C itself; second: p_2 = R_KC p_C + t_KC.
/// rank_deficient: the two rays are parallel, or the cameras stand in one place.
template <typename S>
Status triangulate(const Eigen::Matrix<S, 2, 1>& xy_1, const Eigen::Matrix<S, 2, 1>& xy_2,
                   const Eigen::Matrix<S, 3, 3>& R_KC, const Eigen::Matrix<S, 3, 1>& t_KC, const S& least_pivot,
                   Eigen::Matrix<S, 3, 1>& p_C) {
  NormalEquations<S, 3> equations;
  equations.clear();
  for (int k = 0; k < 2; ++k) {
    const S zero(0);
    equations.add({k == 0 ? S(-1) : zero, k == 1 ? S(-1) : zero, xy_1(k)}, zero);
    const S& v = xy_2(k);
    equations.add({v * R_KC(2, 0) - R_KC(k, 0), v * R_KC(2, 1) - R_KC(k, 1), v * R_KC(2, 2) - R_KC(k, 2)},
                  t_KC(k) - v * t_KC(2));
  }
  const Status status = equations.factorise(least_pivot);
  if (status != Status::ok) return status;
  S gain;
  p_C = equations.solution(gain);
  return Status::ok;
}

}  // namespace relnav
