#pragma once
/// What passes from the light-spot finder (vision) to the cooperative estimators.
#include <cstdint>

#include "fsw/base/bounded_vector.hpp"
#include "fsw/config.hpp"
#include "fsw/math/types.hpp"

namespace relnav {

struct LightSpot {
  Vec2 uv_px = Vec2::Zero();      ///< centroid (distorted image coordinates)
  double sigma_px = 1.0;          ///< 1 sigma of each coordinate
  double flux = 0.0;              ///< sum of grey levels above the background, in units of a full-scale pixel
  std::int32_t area_px = 0;       ///< pixels above the threshold
  std::int32_t saturated_px = 0;  ///< of these, at full scale
};

/// Strongest first.
using LightSpots = BoundedVector<LightSpot, config::max_spots>;

}  // namespace relnav
