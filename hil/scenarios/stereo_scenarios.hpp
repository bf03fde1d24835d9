#pragma once
#include "hil/scenarios/scenario.hpp"

namespace relnav::hil {

/// Scenarios of Chen, Chen, Wang, Chinese Space Science and Technology 35(4), 2015 (cooperative-stereo.md): two parallel
/// cameras, f = 35 mm, 4256 x 2832 px on 36.0 x 23.9 mm; a square of four points seen from the middle of the baseline.
/// Not printed there, chosen after the reproduction: baseline 1 m (cam1 at +x of cam0), half diagonal 0.5 m, 4.2 m. One
/// epoch a second.

/// Noise swept from 0 to options.sigma_px in eight equal steps, the square facing the cameras; the column sigma tells the
/// level (noise_free_sigma_px: none). `options.count` epochs a level (0: 200).
[[nodiscard]] Scenario stereo_noise_scenario(const ScenarioOptions& options);

/// Pose swept at one noise level: pitch, yaw, roll (about x, y, z of C, one at a time) -40 .. 40 deg each 5 deg, then
/// the range 3 .. 10 m each 0.5 m. `options.count` epochs a pose (0: 50).
[[nodiscard]] Scenario stereo_pose_scenario(const ScenarioOptions& options);

inline constexpr double stereo_baseline_m = 1.0;
inline constexpr double stereo_half_diagonal_m = 0.5;
inline constexpr double stereo_range_m = 4.2;
inline constexpr int stereo_noise_steps = 8;

}  // namespace relnav::hil
