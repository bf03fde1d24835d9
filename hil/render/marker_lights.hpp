#pragma once
#include "fsw/geometry/camera_model.hpp"
#include "fsw/geometry/target_model.hpp"
#include "hil/render/mesh_scene.hpp"
#include "hil/render/point_spread.hpp"
#include "hil/render/view.hpp"

namespace relnav::hil {

/// The markers' balls as the lens draws them: each ball's outline is filled with points, which go through the camera model
/// one by one, are hidden by what stands before them, and are spread and integrated over pixels exactly. What pixels on a
/// grid would do to a spot of one or two of them (its centroid sticks to their centres) does not arise.
/// A light with a normal is dark from behind, and fades within 12 deg of the face's plane.
void draw_lights(const TargetModel& lights, float radiance, const ViewOfRows& views, const CameraModel& camera,
                 const MeshScene& scene, double sigma_px, float weight, Plane& points);

}  // namespace relnav::hil
