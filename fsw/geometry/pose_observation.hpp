#pragma once
#include <cstdint>

#include "fsw/base/bounded_vector.hpp"
#include "fsw/config.hpp"
#include "fsw/math/types.hpp"

namespace relnav {

/// A target feature seen by a camera of the rig.
struct PoseObservation {
  std::uint16_t feature = 0;  ///< position in TargetModel::features
  std::uint16_t camera = 0;   ///< position in the CameraRig
  Vec2 uv_px = Vec2::Zero();
  double sigma_px = 1.0;  ///< 1 sigma of each coordinate, > 0
};

using PoseObservations = BoundedVector<PoseObservation, config::max_observations>;

/// Pose of T in C0.
struct Pose {
  Mat3 R_CT = Mat3::Identity();
  Vec3 t_CT = Vec3::Zero();  ///< m
};

/// A solved pose and how far it can be believed.
struct PoseEstimate {
  Pose pose;
  Mat6 covariance = Mat6::Identity();  ///< order [dt dphi], m and rad, R_true = Exp([dphi x]) R_est
  double chi2 = 0.0;                   ///< of the residuals of the observations used
  int degrees_of_freedom = 0;
  int used = 0;  ///< observations
  int iterations = 0;
};

}  // namespace relnav
