#include "hil/simulation/scene_motion.hpp"

#include "hil/evaluate/rotation.hpp"

namespace relnav::hil {

SceneState moved_on(const SceneState& state, Time time) {
  const double dt_s = (time - state.time).seconds();
  SceneState later = state;
  later.time = time;
  later.t_CT += dt_s * state.velocity_C;
  later.R_CT = rotation_exp(Vec3(dt_s * state.omega_CT_C)) * state.R_CT;
  return later;
}

SceneState seen_by(const RigCamera& camera, const SceneState& state) {
  const Mat3& R = camera.R_KC;
  SceneState seen = state;
  seen.t_CT = R * state.t_CT + camera.t_KC;
  seen.R_CT = R * state.R_CT;
  seen.velocity_C = R * state.velocity_C;
  seen.omega_CT_C = R * state.omega_CT_C;
  seen.R_CI = R * state.R_CI;
  seen.sun_C = R * state.sun_C;
  seen.earth_C = R * state.earth_C + camera.t_KC;
  return seen;
}

}  // namespace relnav::hil
