#pragma once
#include <vector>

#include "fsw/geometry/camera_rig.hpp"
#include "hil/io/trajectory.hpp"
#include "hil/simulation/scenario_file.hpp"
#include "hil/simulation/scene_state.hpp"
#include "hil/simulation/simulated_camera.hpp"

namespace relnav::hil {

/// Everything about a run that does not depend on the flight code: it is known before the first frame.
struct SimulationPlan {
  CameraRig told_rig;  ///< as the flight is told
  CameraRig true_rig;
  std::vector<PlannedFrame> frames;
  std::vector<SceneState> truth;  ///< at the true mid-exposures, one a frame
  Trajectory truth_at_stamps;     ///< what an estimate with a frame's stamp is compared with
};

/// Stamps begin here, s.
inline constexpr std::int64_t simulation_start_ns = 100'000'000'000;

/// Throws InputError: the target is behind the camera in some frame, or a camera model is impossible.
[[nodiscard]] SimulationPlan plan_simulation(const SimulationScenario& scenario);

}  // namespace relnav::hil
