#include "fsw/estimation/measurement_model.hpp"

#include "fsw/attitude/so3.hpp"
#include "fsw/estimation/inverse_depth.hpp"

namespace relnav {

Vec3 feature_direction_C(const PoseLinearisation& pose, const Feature& feature) {
  if (feature.size == 3) return pose.R_CT * feature.y.head<3>() + pose.t_CT;
  const double rho = feature.y(5);
  const Vec3 m = inverse_depth::ray_T(feature.y(3), feature.y(4));
  return pose.R_CT * (rho * feature.y.head<3>() + m) + rho * pose.t_CT;
}

Vec3 feature_point_T(const Feature& feature, double range_m, Mat<3, 6>& J) {
  if (feature.size == 3) {
    J.setZero();
    J.block<3, 3>(0, 0).setIdentity();
    return feature.y.head<3>();
  }
  Vec6 y = feature.y;
  const double least_rho = 1e-3 / range_m;
  if (!(y(5) > least_rho)) y(5) = least_rho;
  return inverse_depth::point_T(y, J);
}

Vec3 feature_point_T(const Feature& feature, double range_m) {
  Mat<3, 6> ignored;
  return feature_point_T(feature, range_m, ignored);
}

Status predict_pixel(const CameraModel& camera, const PoseLinearisation& pose, const Feature& feature, Vec2& uv_px) {
  return camera.project(feature_direction_C(pose, feature), uv_px);
}

Status predict_image(const CameraModel& camera, const PoseLinearisation& pose, const Feature& feature,
                     PredictedImage& image) {
  image.H = SparseRowPair{};
  image.H.feature_offset = feature.offset;
  image.H.feature_size = feature.size;

  Mat<3, 6> J_feature;
  Vec3 rotated_C;  // the part of h that turns with the target
  double rho = 1.0;
  if (feature.size == 3) {
    rotated_C = pose.R_CT * feature.y.head<3>();
    J_feature.setZero();
    J_feature.block<3, 3>(0, 0) = pose.R_CT;
  } else {
    rho = feature.y(5);
    Vec3 dm_dtheta;
    Vec3 dm_dphi;
    const Vec3 m = inverse_depth::ray_T(feature.y(3), feature.y(4), dm_dtheta, dm_dphi);
    rotated_C = pose.R_CT * (rho * feature.y.head<3>() + m);
    J_feature.block<3, 3>(0, 0) = rho * pose.R_CT;
    J_feature.col(3) = pose.R_CT * dm_dtheta;
    J_feature.col(4) = pose.R_CT * dm_dphi;
    J_feature.col(5) = pose.R_CT * feature.y.head<3>() + pose.t_CT;
  }
  const Vec3 h_C = rotated_C + rho * pose.t_CT;

  Mat23 J_uv_h;
  const Status status = camera.project(h_C, image.uv_px, J_uv_h);
  if (status != Status::ok) return status;

  Mat<3, 6> J_pose;  // d h / d[dt_CT, dphi_C]
  J_pose.block<3, 3>(0, 0) = rho * Mat3::Identity();
  J_pose.block<3, 3>(0, 3) = -cross_matrix(rotated_C);
  const Mat<2, 6> H_motion = J_uv_h * (J_pose * pose.J);
  const Mat<2, 6> H_feature = J_uv_h * J_feature;
  for (int r = 0; r < 2; ++r) {
    for (int c = 0; c < 6; ++c) image.H.motion[r][c] = H_motion(r, c);
    for (int c = 0; c < feature.size; ++c) image.H.feature[r][c] = H_feature(r, c);
  }
  return Status::ok;
}

Mat2 image_covariance(const FilterState& state, const SparseRowPair& H) {
  // Only the twelve states that H touches: position, attitude, and the feature's own block.
  constexpr int pose_states = 6;
  const int size = pose_states + H.feature_size;
  int column[12];
  double row[2][12];
  for (int k = 0; k < pose_states; ++k) {
    column[k] = k;
    row[0][k] = H.motion[0][k];
    row[1][k] = H.motion[1][k];
  }
  for (int k = 0; k < H.feature_size; ++k) {
    column[pose_states + k] = H.feature_offset + k;
    row[0][pose_states + k] = H.feature[0][k];
    row[1][pose_states + k] = H.feature[1][k];
  }
  Mat2 S = Mat2::Zero();
  for (int j = 0; j < size; ++j) {
    double ph[2] = {0.0, 0.0};  // P(:, j) weighted by each row
    for (int i = 0; i < size; ++i) {
      const double p = state.P_at(column[i], column[j]);
      ph[0] += row[0][i] * p;
      ph[1] += row[1][i] * p;
    }
    S(0, 0) += ph[0] * row[0][j];
    S(0, 1) += ph[0] * row[1][j];
    S(1, 1) += ph[1] * row[1][j];
  }
  S(1, 0) = S(0, 1);
  return S;
}

}  // namespace relnav
