#pragma once
#include "hil/dynamics/gravity.hpp"
#include "hil/dynamics/orbit.hpp"
#include "hil/dynamics/turning.hpp"

namespace relnav::hil {

// The local frame L of a spacecraft: x along the track (V-bar, near the velocity), y against the orbit's normal (H-bar),
// z to the Earth's centre (R-bar); Fehse, Automated Rendezvous and Docking of Spacecraft, 2003, section 3.1.

/// How L stands and turns in I.
[[nodiscard]] Turning local_frame(const InertialState& state, Gravity gravity);

/// Another spacecraft in L, its velocity as L sees it.
struct LocalState {
  Vec3 p_L = Vec3::Zero();  ///< m
  Vec3 v_L = Vec3::Zero();  ///< m/s
};

/// `il`: the local frame of `origin`.
[[nodiscard]] LocalState local_state(const InertialState& other, const InertialState& origin, const Turning& il);
[[nodiscard]] InertialState inertial_state(const LocalState& other, const InertialState& origin, const Turning& il);

/// Clohessy, Wiltshire, J. Aerospace Sciences 27(9), 1960, in the axes of L as in Fehse, eq. 3.22: free motion near a
/// circular orbit of the mean motion `n` (rad/s), to first order in the distance.
[[nodiscard]] LocalState clohessy_wiltshire(const LocalState& start, double n, double t_s);

}  // namespace relnav::hil
