#include "hil/simulation/simulation_plan.hpp"

#include <cmath>
#include <stdexcept>

#include "hil/dynamics/relative_motion.hpp"
#include "hil/scenarios/gaussian.hpp"

#include "hil/simulation/scene_motion.hpp"
#include "platform/files/camera_rig_file.hpp"
#include "platform/files/input_error.hpp"
#include "platform/files/text.hpp"

namespace relnav::hil {
namespace {

CameraCalibration with_error(CameraCalibration camera, const CalibrationError& error) {
  CameraIntrinsics& k = camera.intrinsics;
  k.fu += error.fu_px;
  k.fv += error.fv_px;
  k.cu += error.cu_px;
  k.cv += error.cv_px;
  if (error.k1 != 0.0) {
    if (k.model == DistortionModel::none) k.model = DistortionModel::radial_tangential;
    k.coefficients[0] += error.k1;
  }
  return camera;
}

/// By how much the camera's clock is off in frame `number`.
std::int64_t clock_jump_ns(const SimulationScenario& scenario, std::int64_t number) {
  double jump_s = 0.0;
  for (const Fault& fault : scenario.faults) {
    if (fault.kind == FaultKind::time_jump && number >= static_cast<std::int64_t>(fault.frame)) jump_s += fault.amount;
  }
  return std::llround(jump_s * 1e9);
}

/// A clock that has jumped names the instants otherwise; only what is left is an error of the stamp.
TimedPose pose_at_stamp(const SceneState& state, std::int64_t jump_ns, Time stamp) {
  TimedPose pose = pose_of(moved_on(state, Time{stamp.ns - jump_ns}));
  pose.time = stamp;
  return pose;
}

/// What only the course of a run shows (a random drift through the target) is about the file, too.
SceneState state_at(RelativeMotion& motion, Time time, const std::string& file) {
  try {
    return motion.at(time);
  } catch (const std::domain_error& error) {
    throw InputError(file, 0, format_text("after %.3f s: ", (time - Time{}).seconds()) + error.what(),
                     "a way around it");
  }
}

}  // namespace

SimulationPlan plan_simulation(const SimulationScenario& scenario) {
  SimulationPlan plan;
  plan.told_rig = camera_rig_of(scenario.cameras, scenario.camera_files);
  std::vector<CameraCalibration> real;
  for (const CameraCalibration& camera : scenario.cameras)
    real.push_back(with_error(camera, scenario.calibration_error));
  plan.true_rig = camera_rig_of(real, scenario.camera_files);

  RelativeMotion motion(scenario.motion, scenario.seed);
  Gaussian jitter(scenario.seed ^ 0x717);
  const auto count = static_cast<std::int64_t>(std::floor(scenario.duration_s * scenario.rate_hz)) + 1;
  for (std::int64_t k = 0; k < count; ++k) {
    const Time since_start{std::llround(static_cast<double>(k) / scenario.rate_hz * 1e9)};
    SceneState state = state_at(motion, since_start, scenario.path);
    state.time = Time{simulation_start_ns + since_start.ns};
    if (!(state.t_CT.z() > 0.0)) {
      throw InputError(scenario.path, 0,
                       format_text("the target is behind the camera after %.3f s, at z = %.3f m",
                                   (since_start - Time{}).seconds(), state.t_CT.z()),
                       "a motion that keeps the target in front of the camera");
    }
    const Time stamp =
        state.time + Duration{std::llround(scenario.stamp_jitter_s * jitter.next() * 1e9) + clock_jump_ns(scenario, k)};
    plan.frames.push_back({state.time, stamp});
    plan.truth.push_back(state);
    if (plan.truth_at_stamps.empty() || stamp > plan.truth_at_stamps.back().time)
      plan.truth_at_stamps.push_back(pose_at_stamp(state, clock_jump_ns(scenario, k), stamp));
  }
  return plan;
}

}  // namespace relnav::hil
