#pragma once
#include "fsw/estimation/stereo_closed_form.hpp"

namespace relnav {

/// Covariance [dt dphi] of a closed form over triangulated points: the pixels' noise carried to first order through
/// triangulation and closed form, P = sum over the pixel coordinates of sigma^2 (d pose / d coordinate) (...)', derivatives
/// by central differences. 8 solutions a point, so 32 for four features. To first order only: honest while the noise
/// turns the pose by a few degrees, too small beyond 10 deg (figures: docs/cooperative-scenarios.md).
/// `solve(points, pose)` is the closed form. `points` are as before afterwards, unless there is an error: that of
/// triangulate_pixels() or of `solve`, next to where both had an answer.
template <typename Solve>
Status propagate_pixel_noise(const CameraRig& rig, const PoseObservations& observations, StereoPoints& points,
                             const Solve& solve, Mat6& covariance) {
  // Of a sigma: small against what bends, large against rounding.
  constexpr double step = 0.01;
  covariance.setZero();
  for (std::size_t i = 0; i < points.p_C.size(); ++i) {
    const Vec3 p_C = points.p_C[i];
    for (std::size_t coordinate = 0; coordinate < 4; ++coordinate) {
      const std::size_t camera = coordinate / 2;
      const double step_px = step * observations[points.observation[i][camera]].sigma_px;
      std::array<Pose, 2> moved;
      for (std::size_t side = 0; side < 2; ++side) {
        std::array<Vec2, 2> uv_px{observations[points.observation[i][0]].uv_px,
                                  observations[points.observation[i][1]].uv_px};
        uv_px[camera](static_cast<Eigen::Index>(coordinate % 2)) += side == 0 ? -step_px : step_px;
        Status status = triangulate_pixels(rig, uv_px[0], uv_px[1], points.p_C[i]);
        if (status == Status::ok) status = solve(points, moved[side]);
        if (status != Status::ok) return status;
      }
      const Mat3 turn = moved[1].R_CT * moved[0].R_CT.transpose();
      Vec6 column;
      column << moved[1].t_CT - moved[0].t_CT,
          0.5 * Vec3(turn(2, 1) - turn(1, 2), turn(0, 2) - turn(2, 0), turn(1, 0) - turn(0, 1));
      column /= 2.0 * step;
      covariance += column * column.transpose();
    }
    points.p_C[i] = p_C;
  }
  return Status::ok;
}

}  // namespace relnav
