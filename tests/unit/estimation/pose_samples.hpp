#pragma once
// What the tests of poses from features share: targets, rigs, random poses, noisy observations, and a maximum-likelihood
// solver of its own (dense, numeric Jacobians) that shares nothing with the code under test but the camera model.
#include <vector>

#include "fsw/estimation/pose_least_squares.hpp"
#include "tests/support/normal.hpp"
#include "tests/unit/attitude/attitude_samples.hpp"

namespace relnav::test {

constexpr double degrees_per_radian = 57.29577951308232;

CameraModel camera_of(const CameraIntrinsics& k);

/// 55 deg wide, without distortion.
CameraIntrinsics pinhole();

/// The paper's camera: 2048 x 2048 px of 7 um, f = 200 mm (cooperative-mono.md).
CameraIntrinsics long_focus();

/// The stereo paper's: f = 35 mm, 4256 x 2832 px on 36.0 x 23.9 mm (cooperative-stereo.md).
CameraIntrinsics stereo_paper_camera();

CameraIntrinsics distorted(DistortionModel model);

CameraRig mono_rig(const CameraIntrinsics& k);

/// The second camera turned by R_10 and standing at p_C0.
CameraRig stereo_rig(const CameraIntrinsics& k0, const CameraIntrinsics& k1, const Mat3& R_10, const Vec3& p_C0);

TargetModel target_of(const std::vector<Vec3>& points);

std::vector<Vec3> cube(double half_width);

/// Corners A, B, C, D in the plane z = 0 about `middle`: x toward C, y toward D.
std::vector<Vec3> square(double half_diagonal, const Vec3& middle = Vec3::Zero());

/// Uniform over SO(3).
Mat3 random_attitude(Normal& rng);

/// Exactly half a turn about a random axis.
Mat3 random_half_turn(Normal& rng);

double rotation_angle(const Mat3& A, const Mat3& B);

/// [dt dphi] that takes `from` to `to`.
Vec6 pose_difference(const Pose& from, const Pose& to);

Pose moved_pose(const Pose& pose, const Vec6& d);

Vec3 in_camera(const CameraRig& rig, std::size_t camera, const Pose& pose, const Vec3& p_T);

/// Adds the feature as a camera sees it, with noise; false if it has no image.
bool see(const CameraRig& rig, const TargetModel& target, const Pose& pose, std::size_t camera, std::size_t feature,
         double sigma_px, Normal& rng, PoseObservations& out, double noise_factor = 1.0);

/// Every feature in every camera. noise_factor 0: exact images.
PoseObservations see_all(const CameraRig& rig, const TargetModel& target, const Pose& pose, double sigma_px,
                         Normal& rng, double noise_factor = 1.0);

ObservationMask all_used();

/// Whitened residuals of all observations, observed minus predicted; NaN where there is no image.
Eigen::VectorXd residuals(const CameraRig& rig, const TargetModel& target, const PoseObservations& observations,
                          const Pose& pose);

/// d (predicted, whitened) / d [dt dphi], by central differences.
Eigen::MatrixXd pose_jacobian(const CameraRig& rig, const TargetModel& target, const PoseObservations& observations,
                              const Pose& pose);

/// Cramer-Rao bound at a pose.
Mat6 pose_bound(const CameraRig& rig, const TargetModel& target, const PoseObservations& observations,
                const Pose& pose);

/// Levenberg-Marquardt by QR to the end of double precision, from a start in the basin.
Pose reference_optimum(const CameraRig& rig, const TargetModel& target, const PoseObservations& observations,
                       Pose pose);

}  // namespace relnav::test
