#pragma once
#include <array>

#include "fsw/estimation/spot_scene.hpp"

namespace relnav {

/// Where the spots of a rig's first camera can lie in space, by those of the second that they can be the image of: within a few
/// sigmas of the epipolar line, at a depth that the range of the target allows. Bounds the distance of any two of them, which
/// leaves few triples of markers that three spots can be.
class SpotMates {
 public:
  /// Squared distance of two points, m^2.
  struct Span {
    double least2 = 0.0;
    double most2 = 0.0;
  };

  /// For a rig of two cameras. A spot with more mates than there is room for has its strongest.
  void build(const SpotScene& scene);
  /// Spots of the first camera that have a mate, by position in its LightSpots.
  [[nodiscard]] SpotField::Mask mated() const { return mated_; }
  /// Both have a mate. Over all their mates.
  [[nodiscard]] Span distance(std::size_t a, std::size_t b) const;

 private:
  static constexpr std::size_t most_mates = 4;
  struct Place {
    Vec3 p_C = Vec3::Zero();  ///< middle of the stretch of the ray, m
    double half_m = 0.0;      ///< half its length
  };
  using Places = BoundedVector<Place, most_mates>;

  std::array<Places, config::max_spots> places_{};
  SpotField::Mask mated_ = 0;
};

}  // namespace relnav
