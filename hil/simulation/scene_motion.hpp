#pragma once
#include <vector>

#include "fsw/geometry/camera_rig.hpp"
#include "hil/io/trajectory.hpp"
#include "hil/simulation/scene_state.hpp"

namespace relnav::hil {

/// The same scene shortly before or after: constant rate and velocity. Good for an exposure and for a stamp that is a little off.
[[nodiscard]] SceneState moved_on(const SceneState& state, Time time);

/// As another camera of the rig sees it: p_K = R_KC p_C + t_KC.
[[nodiscard]] SceneState seen_by(const RigCamera& camera, const SceneState& state);

[[nodiscard]] inline TimedPose pose_of(const SceneState& state) { return {state.time, state.t_CT, state.R_CT}; }

}  // namespace relnav::hil
