#include "hil/dynamics/relative_motion.hpp"

#include <stdexcept>

#include "hil/dynamics/eclipse.hpp"

namespace relnav::hil {
namespace {

double seconds_of(Time time) { return static_cast<double>(time.ns) * 1e-9; }

/// From R_0T on, T turns at a constant rate in its own axes.
Turning steady_turn(const Mat3& R_0T, const Vec3& omega_T, double t_s) {
  return {R_0T * rotation_exp(omega_T * t_s), R_0T * omega_T};
}

}  // namespace

RelativeMotion::RelativeMotion(const MotionSettings& settings, std::uint64_t seed)
    : settings_(settings),
      orbit_(settings.orbit, settings.gravity()),
      profile_(settings.chaser, orbit_, 3 * seed + 1000),
      jitter_(settings.chaser.jitter, 3 * seed + 1) {
  if (settings_.chaser.orbit) own_orbit_.emplace(settings_.chaser.orbit, settings_.gravity());
  start_target();
  if (settings_.target.stabilised == Stabilised::none) {
    body_.emplace(settings_.target.inertia_T, R_0T_, settings_.target.omega_T, settings_.target.torque_density,
                  3 * seed + 2);
  }
}

void RelativeMotion::start_target() {
  const ReferenceOrbit::Now now = orbit_.at(Time{0});
  const Mat3 R_LC = camera_at(Time{0}, now, Turning{}).lc.R_AB;
  const TargetSettings& target = settings_.target;
  const Mat3 R_LT = target.relative_to_camera ? Mat3(R_LC * target.R_0T) : target.R_0T;
  switch (target.stabilised) {
    case Stabilised::none:
    case Stabilised::inertial: R_0T_ = now.il.R_AB * R_LT; break;
    case Stabilised::lvlh: R_0T_ = R_LT; break;
    case Stabilised::camera: R_0T_ = R_LC.transpose() * R_LT; break;
  }
  const Mat3 R_IC = now.il.R_AB * R_LC;
  sun_I_ = settings_.sun_I ? *settings_.sun_I : Vec3(R_IC * settings_.sun_C);
}

Turning RelativeMotion::target_attitude(Time time, const ReferenceOrbit::Now& target, const Turning& lc) {
  if (body_) return compose(inverse(target.il), body_->at(time));
  const Turning turn = steady_turn(R_0T_, settings_.target.omega_T, seconds_of(time));
  if (settings_.target.stabilised == Stabilised::camera) return compose(lc, turn);
  return settings_.target.stabilised == Stabilised::lvlh ? turn : compose(inverse(target.il), turn);
}

CameraMotion RelativeMotion::camera_on_own_orbit(Time time, const ReferenceOrbit::Now& target) {
  const ReferenceOrbit::Now own = own_orbit_->at(time);
  const LocalState at = local_state(own.state, target.state, target.il);
  const ChaserSettings& chaser = settings_.chaser;
  if (!chaser.own_frame) return {at, compose(aimed_at_target(at, chaser.down_L), {chaser.R_PC, Vec3::Zero()})};
  const Turning own_to_camera = steady_turn(chaser.R_LC, chaser.omega_LC_C, seconds_of(time));
  return {at, compose(inverse(target.il), compose(own.il, own_to_camera))};
}

CameraMotion RelativeMotion::camera_at(Time time, const ReferenceOrbit::Now& target, const Turning& lt) {
  return own_orbit_ ? camera_on_own_orbit(time, target) : profile_.at(time, target, lt);
}

SceneState RelativeMotion::at(Time time) {
  if (time < last_) throw std::invalid_argument("dynamics: time goes back");
  last_ = time;
  if (!own_orbit_) profile_.advance(time, orbit_);
  const ReferenceOrbit::Now target = orbit_.at(time);
  // Of the two, the one that the other follows comes first.
  const bool camera_first = settings_.target.stabilised == Stabilised::camera;
  const Turning lt_first = camera_first ? Turning{} : target_attitude(time, target, Turning{});
  const CameraMotion camera = camera_at(time, target, lt_first);
  const Turning lt = camera_first ? target_attitude(time, target, camera.lc) : lt_first;

  const Turning lc = compose(camera.lc, jitter_.at(seconds_of(time)));
  const Turning cl = inverse(lc);
  const Turning ct = compose(cl, lt);
  SceneState scene;
  scene.time = time;
  scene.R_CT = ct.R_AB;
  scene.omega_CT_C = ct.omega_AB_A;
  scene.t_CT = -cl.R_AB * camera.at.p_L;
  scene.velocity_C = -cl.R_AB * camera.at.v_L + cl.omega_AB_A.cross(scene.t_CT);
  scene.R_CI = cl.R_AB * target.il.R_AB.transpose();
  scene.sun_C = scene.R_CI * sun_I_;
  if (settings_.orbit) {
    scene.sunlight = sunlight_at(target.state.r_I, sun_I_);
    scene.earth_C = scene.t_CT - scene.R_CI * target.state.r_I;
  } else {
    scene.earth_C = scene.R_CI * Vec3(0.0, 0.0, -1.5e11);
  }
  return scene;
}

}  // namespace relnav::hil
