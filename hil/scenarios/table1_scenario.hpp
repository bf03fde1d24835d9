#pragma once
#include "hil/scenarios/scenario.hpp"

namespace relnav::hil {

/// Table 1 of Yue, Hou, J. Astronautics 31(3), 2010 (cooperative-mono.md): a cube of 2 m about 100 m ahead of the chaser
/// on the same orbit, seen along +X_B through f = 200 mm, 6000 s.
///
/// The table leaves open what the attitudes refer to. Here: to each spacecraft's own local frame L (lvlh.hpp; the
/// target would leave the image otherwise), R_LB(0) = Rz(yaw) Ry(pitch) Rx(roll), rates in body axes,
/// R_LB(t) = R_LB(0) Exp([omega_B t x]): the conventions under which the relative attitude passes 180 deg at the paper's
/// 2228.6 s. Both bodies' axes are renamed alike, C = T axes = (Y, Z, X) of the body, which keeps that angle in R_CT.
[[nodiscard]] TimedPose table1_pose(Time time);

inline constexpr double table1_cube_edge_m = 2.0;
inline constexpr std::size_t table1_epochs = 1201;  ///< one each 5 s

/// `options.count` epochs (0: 1201).
[[nodiscard]] Scenario table1_scenario(const ScenarioOptions& options);

}  // namespace relnav::hil
