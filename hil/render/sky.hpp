#pragma once
#include <vector>

#include "hil/render/lighting.hpp"
#include "hil/simulation/scene_state.hpp"

namespace relnav::hil {

struct Star {
  Vec3 direction_I;
  double irradiance;  ///< in that of the sun
};
/// Made up: evenly over the sky, to magnitude 6.5, 3.2 times as many a magnitude. Brightest first; always the same.
[[nodiscard]] const std::vector<Star>& star_catalogue();

/// Earth and sun behind the target. Radiance in the unit of Lighting.
class Sky {
 public:
  /// In C, for one instant.
  Sky(const SceneState& state, double earth_albedo, bool has_earth);

  /// Whether a cone about `axis_C` (unit vector) may show any of it.
  [[nodiscard]] bool may_show(Vec3f axis_C, float half_angle_rad) const;
  /// `toward_C`: unit vector.
  [[nodiscard]] float radiance(Vec3f toward_C) const;
  [[nodiscard]] bool hides_stars(Vec3f toward_C) const;

 private:
  Mat3f R_IC_;
  Vec3f sun_C_;
  Vec3f sun_I_;
  Vec3f earth_C_;   // unit vector
  float distance_;  // in Earth's radii
  float albedo_;
  bool has_earth_;
};

/// Mean radiance of the part of the Earth that is in view.
[[nodiscard]] double mean_earth_radiance(const SceneState& state, double earth_albedo);

}  // namespace relnav::hil
