#pragma once
#include "hil/scenarios/scenario.hpp"

namespace relnav::hil {

enum class RandomTarget { eight_points, cube };

/// Independent poses, evenly over SO(3), every fourth a turn by exactly 180 deg about an axis evenly over the sphere;
/// range 6 .. 7.5 m for a target of about 2 m (size / range near 0.3), off the axis by up to a tenth of the range, all of
/// it in the image of 2048 x 2048 px, f = 2000 px. The cube (edge 2 m) shows the vertices of the faces turned to the camera,
/// a single face at times; the eight points are all seen. One epoch a second, `options.count` of them (0: 10,000).
[[nodiscard]] Scenario random_scenario(RandomTarget target, const ScenarioOptions& options);

}  // namespace relnav::hil
