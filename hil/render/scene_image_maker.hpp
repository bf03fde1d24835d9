#pragma once
#include "hil/simulation/image_maker.hpp"

namespace relnav::hil {

/// ImageMakerFactory of rendered frames: section `render` of the scenario, its lights, one camera. Throws InputError.
[[nodiscard]] std::unique_ptr<ImageMaker> make_scene_image_maker(const SimulationScenario& scenario,
                                                                 const CameraModel& camera, std::uint64_t seed);

}  // namespace relnav::hil
