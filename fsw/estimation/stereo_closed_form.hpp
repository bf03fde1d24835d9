#pragma once
#include <array>

#include "fsw/geometry/camera_rig.hpp"
#include "fsw/geometry/pose_observation.hpp"
#include "fsw/geometry/target_model.hpp"

namespace relnav {

/// Features seen by both cameras of a rig, in T and triangulated in C0. Position in all arrays is the same.
template <typename S>
struct StereoPointsIn {
  using Vector = Eigen::Matrix<S, 3, 1>;
  BoundedVector<std::uint16_t, config::max_target_features> feature;  ///< position in TargetModel::features
  /// Of each camera: position in PoseObservations.
  BoundedVector<std::array<std::uint16_t, 2>, config::max_target_features> observation;
  BoundedVector<Vector, config::max_target_features> p_T;
  BoundedVector<Vector, config::max_target_features> p_C;
};
using StereoPoints = StereoPointsIn<double>;

enum class MotorLines : std::uint8_t {
  target,  ///< the target's own lines; if it has none: from each feature to the next (AB, BC, CD: the paper's)
  all,     ///< every pair of features
};

/// Normalised, undistorted. Errors of CameraModel::unproject(); outside_domain: not in front of the camera.
Status normalised_image(const RigCamera& camera, const Vec2& uv_px, Vec2& xy);

/// Point from its pixels in both cameras of a rig, by linear triangulation. Errors of CameraModel::unproject() and
/// triangulate(); behind_camera: the rays meet behind C0.
Status triangulate_pixels(const CameraRig& rig, const Vec2& uv_0_px, const Vec2& uv_1_px, Vec3& p_C);

/// Linear triangulation of each feature that both cameras see. invalid_argument: rig without two cameras, index outside;
/// errors of CameraModel::unproject(). A feature whose rays are parallel, or meet behind C0, is left out;
/// inconsistent: that is more than half of them (cameras swapped or badly calibrated; far away also noise).
Status triangulate_features(const CameraRig& rig, const TargetModel& target, const PoseObservations& observations,
                            StereoPoints& points);

/// Chen, Chen, Wang 2015: motor from feature lines, two linear systems (rotor, then translator). A closed form that starts
/// the maximum-likelihood solution; on its own 4 to 5 times less accurate, since depth counts like the image plane.
/// too_few_features: fewer than 3 points; rank_deficient: the lines are parallel or the points lie on a line.
Status solve_motor(const TargetModel& target, const StereoPoints& points, MotorLines lines, Pose& out);

/// The paper's method of comparison: for triples (A, B, C) of neighbouring features the vectors AB, AC, AB x AC, unit length,
/// one rotation for all of them; position: the mean of the points, hence right only for a layout centred on T's origin.
/// Errors as solve_motor().
Status solve_orthogonal(const StereoPoints& points, Pose& out);

}  // namespace relnav
