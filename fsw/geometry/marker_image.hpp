#pragma once
#include "fsw/attitude/so3.hpp"
#include "fsw/geometry/camera_rig.hpp"
#include "fsw/geometry/pose_observation.hpp"

namespace relnav {

/// Image of a point of the target in a camera of the rig, and how it moves with the pose.
struct MarkerImage {
  Vec2 uv_px = Vec2::Zero();
  Mat<2, 6> J = Mat<2, 6>::Zero();  ///< d uv / d [dt dphi], px/m and px/rad; error state as in PoseEstimate
};

/// p_K = R_KC (R_CT p_T + t_CT) + t_KC, and with R = Exp([dphi x]) R_CT: d p_C = dt - [R_CT p_T x] dphi. Status as
/// CameraModel::project.
[[nodiscard]] inline Status image_of(const RigCamera& camera, const Vec3& p_T, const Pose& pose, MarkerImage& out) {
  const Vec3 X_r = pose.R_CT * p_T;
  Mat23 J_uv_p;
  const Status status = camera.model.project(Vec3(camera.R_KC * (X_r + pose.t_CT) + camera.t_KC), out.uv_px, J_uv_p);
  if (status != Status::ok) return status;
  out.J.leftCols<3>() = J_uv_p * camera.R_KC;
  out.J.rightCols<3>() = -(out.J.leftCols<3>() * cross_matrix(X_r));
  return Status::ok;
}

}  // namespace relnav
