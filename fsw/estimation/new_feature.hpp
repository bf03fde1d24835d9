#pragma once
#include "fsw/base/status.hpp"
#include "fsw/estimation/filter_state.hpp"
#include "fsw/estimation/motion_model.hpp"
#include "fsw/geometry/camera_model.hpp"

namespace relnav {

/// What is believed of a point seen for the first time.
struct NewFeatureSettings {
  bool on_target = true;             ///< part of a rigid target, not of an unknown scene
  double range_m = 1.0;              ///< start range
  double relief = 0.1;               ///< relative depth spread
  double first_view_sigma_px = 0.1;  ///< how well a patch's first view tells where its point is
};

/// An inverse-depth feature as it goes into the state, without delay (Civera 2008), with its full correlation.
struct NewFeature {
  Feature feature;
  Mat<6, 12> J_motion = Mat<6, 12>::Zero();
  DepthTerms depth_terms;
  Mat6 noise = Mat6::Zero();
  Vec3 ray_C = Vec3::Zero();  ///< of its pixel, z = 1
};

/// Feature at a pixel of the image that belongs to `pose`. Its depth is that of its nearest known neighbours on the target
/// and depends on them as states: a prior that took their estimate for an independent number would confirm with each new
/// feature what the filter believes already, above all a wrong rate. Without neighbours: the target's distance, or in an
/// unknown scene the mean depth seen so far.
/// outside_domain: the pixel has no ray before the camera; the camera's own errors.
Status make_new_feature(const Vec2& uv_px, const CameraModel& camera, const PoseLinearisation& pose,
                        const FilterState& state, const NewFeatureSettings& settings, NewFeature& out);

}  // namespace relnav
