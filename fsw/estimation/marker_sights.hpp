#pragma once
#include "fsw/estimation/spot_tracking.hpp"

namespace relnav {

/// Which markers are in sight, learned from frame to frame: a target model without normals does not say which ones the body
/// hides, and a glint where a hidden one would be passes for it. A marker counts once its spot has agreed, in several frames
/// in a row, with the pose that the others give.
class MarkerSights {
 public:
  void restart() { sights_ = {}; }
  /// The markers of an acquisition are in sight.
  void begin(const PoseObservations& observations);
  /// Fills in `in_sight` and `flux`.
  void mark(ExpectedMarkers& markers) const;
  /// A camera's image is done with: `agreed` holds those of its expected markers whose spot agrees with the frame's pose.
  /// What is not expected is out of sight.
  void record(std::uint16_t camera, const ExpectedMarkers& expected, const SpotAssignment& agreed);

 private:
  static constexpr std::uint8_t needed = 3;  ///< frames
  static constexpr std::uint8_t lost = 1;    ///< of these, with a frame in which it is missed

  struct Sight {
    std::uint8_t frames = 0;
    double flux = 0.0;
  };
  using OfCamera = std::array<Sight, config::max_target_features>;
  std::array<OfCamera, config::max_cameras> sights_{};
};

}  // namespace relnav
