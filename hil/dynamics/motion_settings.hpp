#pragma once
#include <optional>
#include <variant>
#include <vector>

#include "hil/dynamics/gravity.hpp"
#include "hil/dynamics/orbit.hpp"
#include "hil/dynamics/pace.hpp"
#include "hil/evaluate/rotation.hpp"

namespace relnav::hil {

// What moves in a scene, as `read_motion` (motion_file.hpp) makes it of a scenario file. L is the target's local frame
// (lvlh.hpp); in free space, where no orbit is, L is I. docs/simulation-motion.md says more.

/// Stay. After `CloseLeg`: on the docking axis.
struct HoldLeg {
  double duration_s = 0.0;
};
/// In a straight line of L, to a place or along the line to the target.
struct StraightLeg {
  std::optional<Vec3> to_L;
  double to_range_m = 0.0;
  LegPace pace;  ///< m
};
/// On a circle about an axis through the target.
struct FlyAroundLeg {
  Vec3 axis_L = Vec3::UnitY();
  double angle_rad = 0.0;
  LegPace pace;  ///< rad
};
/// From where the camera is to a range on the docking axis (-z_T), the camera's axes turning into those of T.
struct CloseLeg {
  double to_range_m = 0.0;
  LegPace pace;  ///< m
};
/// Free motion, beginning with the speed in L at which the leg before ended, or with the given one.
struct DriftLeg {
  double duration_s = 0.0;
  std::optional<Vec3> velocity_L;
  double acceleration_density = 0.0;  ///< of a random acceleration, m/s^1.5
};
using Leg = std::variant<HoldLeg, StraightLeg, FlyAroundLeg, CloseLeg, DriftLeg>;

struct JitterSettings {
  double sigma_rad = 0.0;  ///< each axis
  double frequency_hz = 1.0;
};

struct ChaserSettings {
  Vec3 start_L = Vec3(-10.0, 0.0, 0.0);
  Vec3 down_L = Vec3::UnitZ();   ///< y_C is as near to it as the line of sight allows
  bool follows_target = true;    ///< or keeps the attitude of the start in L
  Mat3 R_PC = Mat3::Identity();  ///< the camera against the frame P that looks at the target
  JitterSettings jitter;
  std::vector<Leg> legs;               ///< one after the other; the last one goes on
  std::optional<OrbitElements> orbit;  ///< the chaser's own, in place of start and legs
  bool own_frame = false;              ///< with an orbit of its own: attitude against its own local frame
  Mat3 R_LC = Mat3::Identity();        ///< with own_frame: at the start
  Vec3 omega_LC_C = Vec3::Zero();      ///< with own_frame: constant, rad/s
};

enum class Stabilised { none, inertial, lvlh, camera };

struct TargetSettings {
  bool relative_to_camera = true;  ///< or to L
  Mat3 R_0T = Mat3::Identity();    ///< at the start: R_CT or R_LT
  /// none: the inertial rate at the start, of a rigid body. Otherwise a constant rate against the frame that is named.
  Vec3 omega_T = Vec3::Zero();  ///< rad/s
  Stabilised stabilised = Stabilised::none;
  Mat3 inertia_T = Mat3::Identity();  ///< kg m^2
  double torque_density = 0.0;        ///< N m s^0.5
};

struct MotionSettings {
  std::optional<OrbitElements> orbit;  ///< the target's; none: free space
  bool j2 = false;
  std::optional<Vec3> sun_I;          ///< unit vector
  Vec3 sun_C = Vec3(0.0, 0.0, -1.0);  ///< unit vector in the camera's first frame, without sun_I
  TargetSettings target;
  ChaserSettings chaser;

  [[nodiscard]] Gravity gravity() const {
    if (!orbit) return Gravity::none;
    return j2 ? Gravity::oblate : Gravity::point_mass;
  }
};

/// z forward along V-bar, y down, x right: the axes that a camera or a target has in L when its angles are zero.
[[nodiscard]] inline Mat3 forward_in_lvlh() {
  return (Mat3() << 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0).finished();
}

}  // namespace relnav::hil
