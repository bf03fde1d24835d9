#pragma once
#include "fsw/base/bounded_vector.hpp"
#include "fsw/config.hpp"
#include "fsw/geometry/camera_model.hpp"

namespace relnav {

/// A camera and where it stands: p_K = R_KC p_C0 + t_KC (m). The first camera of a rig is C0 itself.
struct RigCamera {
  CameraModel model;
  Mat3 R_KC = Mat3::Identity();
  Vec3 t_KC = Vec3::Zero();
};

/// Cameras that see the same target at the same time. Poses are those of T in C0.
using CameraRig = BoundedVector<RigCamera, config::max_cameras>;

}  // namespace relnav
