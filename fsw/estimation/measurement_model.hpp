#pragma once
#include "fsw/base/status.hpp"
#include "fsw/estimation/filter_state.hpp"
#include "fsw/geometry/camera_model.hpp"
#include "fsw/math/covariance_kernels.hpp"

namespace relnav {

/// Image of a feature and how it depends on the state.
struct PredictedImage {
  Vec2 uv_px = Vec2::Zero();
  SparseRowPair H{};  ///< d uv / d x
};

/// Direction from the camera to the feature, in C, scaled by rho for an inverse-depth feature (so it stays finite at
/// infinity): h_C = R_CT (rho (x y z) + m) + rho t_CT, or R_CT X + t_CT. Liu 2017 eq. (17), (18).
[[nodiscard]] Vec3 feature_direction_C(const PoseLinearisation& pose, const Feature& feature);

/// Point in T, and its dependence on the feature's block (Euclidean: the first three columns). An inverse depth under a
/// thousandth of that of the start range, or beyond infinity, counts as that: very far.
[[nodiscard]] Vec3 feature_point_T(const Feature& feature, double range_m, Mat<3, 6>& J);
[[nodiscard]] Vec3 feature_point_T(const Feature& feature, double range_m);

/// Pixel only. Status as CameraModel::project.
Status predict_pixel(const CameraModel& camera, const PoseLinearisation& pose, const Feature& feature, Vec2& uv_px);

/// Pixel and measurement Jacobian, eq. (17)-(22) with the optical image convention of spec/conventions.md.
Status predict_image(const CameraModel& camera, const PoseLinearisation& pose, const Feature& feature,
                     PredictedImage& image);

/// S = H P H' (2 x 2), without measurement noise.
[[nodiscard]] Mat2 image_covariance(const FilterState& state, const SparseRowPair& H);

}  // namespace relnav
