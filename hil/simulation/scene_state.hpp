#pragma once
#include "fsw/base/time.hpp"
#include "fsw/math/types.hpp"

namespace relnav::hil {

/// The truth at an instant, as the first camera (C) sees it. I: inertial, T: target body.
struct SceneState {
  Time time;
  Vec3 t_CT = Vec3::Zero();  ///< m
  Mat3 R_CT = Mat3::Identity();
  Vec3 velocity_C = Vec3::Zero();        ///< d t_CT / dt as C sees it, m/s
  Vec3 omega_CT_C = Vec3::Zero();        ///< rate of T against C, in C: dR_CT/dt = [omega x] R_CT, rad/s
  Mat3 R_CI = Mat3::Identity();          ///< for stars
  Vec3 sun_C = Vec3(0.0, 0.0, -1.0);     ///< unit vector to the sun's centre
  double sunlight = 1.0;                 ///< share of the sun's disc that the Earth leaves free, at the target: 0 .. 1
  Vec3 earth_C = Vec3(0.0, 6.8e6, 0.0);  ///< from the camera to the Earth's centre, m
};

}  // namespace relnav::hil
