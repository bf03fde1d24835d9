#pragma once
#include "fsw/base/time.hpp"
#include "fsw/math/types.hpp"

namespace relnav {

/// What every estimator puts out: the motion of target frame T relative to camera frame C.
struct RelativeState {
  Time time;                     ///< mid-exposure of the frame it belongs to
  Vec3 t_CT = Vec3::Zero();      ///< origin of T in C, m
  Mat3 R_CT = Mat3::Identity();  ///< p_C = R_CT p_T + t_CT
  Vec3 v_C = Vec3::Zero();       ///< d(t_CT)/dt, m/s
  Vec3 omega_C = Vec3::Zero();   ///< angular rate of T relative to C, expressed in C, rad/s: R' = [omega x] R
  Mat6 pose_covariance = Mat6::Identity();  ///< order [dt dphi], m and rad, R_true = Exp([dphi x]) R_est
  Mat6 rate_covariance = Mat6::Identity();  ///< order [dv domega], m/s and rad/s
};

}  // namespace relnav
