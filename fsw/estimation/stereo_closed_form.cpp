#include "fsw/estimation/stereo_closed_form.hpp"

#include <array>

#include "fsw/estimation/motor_solver.hpp"

namespace relnav {
namespace {

constexpr std::size_t least_points = 3;
/// Of the angle at A in a triple (A, B, C), under which three points count as lying on a line.
constexpr double least_sine = 1e-6;

using Line = MotorLine<double>;

}  // namespace

Status normalised_image(const RigCamera& camera, const Vec2& uv_px, Vec2& xy) {
  Vec3 ray_C;
  const Status status = camera.model.unproject(uv_px, ray_C);
  if (status != Status::ok) return status;
  if (!(ray_C.z() > 0.0)) return Status::outside_domain;
  xy = ray_C.head<2>() / ray_C.z();
  return Status::ok;
}

Status triangulate_pixels(const CameraRig& rig, const Vec2& uv_0_px, const Vec2& uv_1_px, Vec3& p_C) {
  Vec2 xy_0;
  Vec2 xy_1;
  Status status = normalised_image(rig[0], uv_0_px, xy_0);
  if (status == Status::ok) status = normalised_image(rig[1], uv_1_px, xy_1);
  if (status == Status::ok) {
    status = triangulate<double>(xy_0, xy_1, rig[1].R_KC, rig[1].t_KC, p_C);
  }
  if (status != Status::ok) return status;
  return p_C.z() > 0.0 ? Status::ok : Status::behind_camera;
}

Status triangulate_features(const CameraRig& rig, const TargetModel& target, const PoseObservations& observations,
                            StereoPoints& points) {
  return triangulate_features<double>(rig, target, observations, 1.0, 1.0, points);
}

Status solve_motor(const TargetModel& target, const StereoPoints& points, MotorLines lines, Pose& out) {
  return solve_motor<double>(target, points, lines, out.R_CT, out.t_CT);
}

Status solve_orthogonal(const StereoPoints& points, Pose& out) {
  const std::size_t n = points.p_T.size();
  if (n < least_points) return Status::too_few_features;
  RotorEquations<double> rotation(3 * n);
  out.t_CT.setZero();
  for (std::size_t i = 0; i < n; ++i) {
    const auto triad = [&](const auto& p, std::array<Vec3, 3>& axes) {
      axes[0] = p[(i + 1) % n] - p[i];
      axes[1] = p[(i + 2) % n] - p[i];
      axes[0].normalize();
      axes[1].normalize();
      axes[2] = Line::cross(axes[0], axes[1]);
      // On a line there is no normal, only rounding errors: leave them as small as they are.
      if (axes[2].norm() > least_sine) axes[2].normalize();
    };
    std::array<Vec3, 3> axes_T;
    std::array<Vec3, 3> axes_C;
    triad(points.p_T, axes_T);
    triad(points.p_C, axes_C);
    for (std::size_t k = 0; k < 3; ++k) rotation.add(axes_T[k], axes_C[k]);
    out.t_CT += points.p_C[i] / static_cast<double>(n);
  }
  return rotation.solve(ScalarTraits<double>::least_gap, out.R_CT);
}

}  // namespace relnav
