#pragma once
#include <array>
#include <cstdint>

#include "fsw/geometry/camera_rig.hpp"
#include "fsw/geometry/light_spot.hpp"

namespace relnav {

/// The light spots of one camera, ready to be asked which of them lies near a predicted image. Works in the normalised
/// image plane (x/z, y/z), free of distortion: a gate of pixels becomes a radius of each spot's own. A grid of
/// cells x cells over the spots holds in each cell the set of those whose gate touches it, so that a question costs one look
/// where there is nothing.
class SpotField {
 public:
  using Mask = std::uint64_t;
  static_assert(config::max_spots <= 64, "a set of spots is one word");

  /// Spots without a viewing ray, or farther than 80 deg off the axis, are left out. `gate_px` > 0.
  void build(const CameraModel& camera, const LightSpots& spots, double gate_px);

  /// Spots that are in, by position in LightSpots.
  [[nodiscard]] Mask present() const { return present_; }
  [[nodiscard]] int count() const { return count_; }
  /// Viewing ray in the camera, unit length.
  [[nodiscard]] const Vec3& ray(std::size_t spot) const { return rays_[spot]; }

  /// Nearest spot within the gate around (x, y) that is not in `taken`; -1: none. d2: squared distance in units of the gate.
  [[nodiscard]] int nearest(double x, double y, Mask taken, double& d2) const;

 private:
  static constexpr int cells = 64;

  std::array<Vec3, config::max_spots> rays_{};
  std::array<Vec2, config::max_spots> xy_{};
  std::array<double, config::max_spots> inverse_gate2_{};
  std::array<Mask, static_cast<std::size_t>(cells) * cells> grid_{};
  Mask present_ = 0;
  int count_ = 0;
  Vec2 corner_ = Vec2::Zero();
  Vec2 scale_ = Vec2::Zero();  ///< cells per unit
};

}  // namespace relnav
