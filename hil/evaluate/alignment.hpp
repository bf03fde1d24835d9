#pragma once
#include <vector>

#include "hil/io/trajectory.hpp"

namespace relnav::hil {

/// r_reference = scale * R r_estimate + t, between the two target frames.
struct Similarity {
  double scale = 1.0;
  Mat3 R = Mat3::Identity();
  Vec3 t = Vec3::Zero();
  bool rotation_from_attitudes = false;  ///< asked for, or the positions lie on a line (or a point) and leave it open
  double straightness = 0.0;  ///< second over first standard deviation of the reference positions; 0: a straight line
};

/// Projection centre of the camera in T.
[[nodiscard]] inline Vec3 camera_centre(const TimedPose& pose) { return -(pose.R_CT.transpose() * pose.t_CT); }

/// Least-squares similarity of the camera centres (Umeyama, IEEE PAMI 13(4), 1991, eq. 40-43), or rigid motion with scale 1.
/// Both of equal length, at least one pose. Throws std::runtime_error when the scale is asked for and nothing moves.
/// With `rotation_from_attitudes` R is the mean of R_CT_true' R_CT_est, and the positions give the rest.
[[nodiscard]] Similarity fit_similarity(const Trajectory& truth, const Trajectory& estimate, bool with_scale,
                                        bool rotation_from_attitudes = false);
[[nodiscard]] Trajectory apply_similarity(const Similarity& similarity, const Trajectory& estimate);

/// A non-cooperative estimate knows its target frame's origin as some body point, at a free scale.
struct BodyPointFit {
  double scale = 1.0;
  Vec3 b_T = Vec3::Zero();  ///< that point in the truth's T, m
  int rank = 0;             ///< of the 4 unknowns; below 4 the minimum-norm solution about the prior is taken
  double condition = 0.0;   ///< of the (column-scaled) least-squares matrix
};

/// Minimises sum |t_true + R_true b - scale t_est|^2. What the data leave open stays at b = 0 and the ratio of first ranges.
[[nodiscard]] BodyPointFit fit_body_point(const Trajectory& truth, const Trajectory& estimate);

}  // namespace relnav::hil
