#pragma once
#include "fsw/geometry/target_model.hpp"
#include "hil/render/mesh.hpp"

namespace relnav::hil {

/// Radius of the luminous balls, m; docs of the data sets in the repository say the same.
inline constexpr double light_radius = 0.015;

/// A made-up satellite: bus of 1.3 m x 1.2 m x 1.4 m in foil around the origin of T, docking face -Z_T with ring, nozzle,
/// boxes and labels, two wings of solar cells along +-Y_T, dish on +X_T, thrusters, rods. 5.3 m from tip to tip.
/// `lights`: brackets that carry them (the balls themselves are the renderer's); may be null.
[[nodiscard]] Mesh make_satellite(const TargetModel* lights);

}  // namespace relnav::hil
