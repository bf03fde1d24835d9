#pragma once
#include <optional>

#include "hil/dynamics/chaser_profile.hpp"
#include "hil/dynamics/jitter.hpp"
#include "hil/dynamics/motion_settings.hpp"
#include "hil/dynamics/rigid_body.hpp"
#include "hil/simulation/scene_state.hpp"

namespace relnav::hil {

/// The motion of chaser and target from time 0 on. The same settings and seed give the same states, whatever times are
/// asked for in between.
class RelativeMotion {
 public:
  RelativeMotion(const MotionSettings& settings, std::uint64_t seed);

  /// Times must not be negative nor go back (std::invalid_argument). Throws std::domain_error where the camera cannot be
  /// aimed (chaser_profile.hpp).
  [[nodiscard]] SceneState at(Time time);

  [[nodiscard]] const ChaserProfile& profile() const { return profile_; }

 private:
  [[nodiscard]] Turning target_attitude(Time time, const ReferenceOrbit::Now& target, const Turning& lc);
  [[nodiscard]] CameraMotion camera_on_own_orbit(Time time, const ReferenceOrbit::Now& target);
  [[nodiscard]] CameraMotion camera_at(Time time, const ReferenceOrbit::Now& target, const Turning& lt);
  void start_target();

  MotionSettings settings_;
  ReferenceOrbit orbit_;
  std::optional<ReferenceOrbit> own_orbit_;
  ChaserProfile profile_;
  Jitter jitter_;
  std::optional<RigidBody> body_;
  Mat3 R_0T_ = Mat3::Identity();  ///< T at the start, in the frame against which it is stabilised
  Vec3 sun_I_ = Vec3::Zero();
  Time last_;
};

}  // namespace relnav::hil
