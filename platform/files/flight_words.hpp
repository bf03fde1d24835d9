#pragma once
#include "fsw/app/flight_config.hpp"
#include "platform/files/file_section.hpp"

namespace relnav {

// What files of flights and of simulations call the same things.
inline constexpr Words<app::NavigationKind, 3> mode_words{{{"noncoop", app::NavigationKind::noncoop},
                                                           {"coop-mono", app::NavigationKind::coop_mono},
                                                           {"coop-stereo", app::NavigationKind::coop_stereo}}};
/// Of the model of an unknown target's motion: rigid target, or else moving camera.
inline constexpr Words<bool, 2> motion_words{{{"rigid-target", true}, {"camera", false}}};

}  // namespace relnav
