#pragma once
#include <optional>

#include "hil/dynamics/motion_settings.hpp"
#include "hil/dynamics/reference_orbit.hpp"

namespace relnav::hil {

/// The camera against the target's local frame: where it is, seen from the target, and how it is aimed.
struct CameraMotion {
  LocalState at;
  Turning lc;
};

/// A frame P at `camera` whose z axis points to the target, y as near to `down_L` as that allows. Throws
/// std::domain_error where the line of sight runs along `down_L` (within 0.5 deg) or the range is zero.
[[nodiscard]] Turning aimed_at_target(const LocalState& camera, const Vec3& down_L);

/// The legs of an approach. What a leg begins with is settled at its beginning, whatever times are asked for.
class ChaserProfile {
 public:
  ChaserProfile(const ChaserSettings& settings, ReferenceOrbit& orbit, std::uint64_t seed);

  /// Begins the legs up to `time`; `orbit`: the target's. Times must not go back.
  void advance(Time time, ReferenceOrbit& orbit);
  /// After advance() to this time. `lt`: T against L.
  [[nodiscard]] CameraMotion at(Time time, const ReferenceOrbit::Now& target, const Turning& lt);

  [[nodiscard]] std::size_t leg() const { return leg_; }
  [[nodiscard]] Time leg_end() const { return leg_end_; }

 private:
  [[nodiscard]] LocalState place(Time time, const ReferenceOrbit::Now& target);
  [[nodiscard]] LocalState left_behind(const ReferenceOrbit::Now& target);
  [[nodiscard]] CameraMotion closing(double t_s, const Turning& lt) const;
  [[nodiscard]] Turning aim(const LocalState& camera) const;
  void begin_leg(Time time, ReferenceOrbit& orbit);

  ChaserSettings settings_;
  std::uint64_t seed_;
  std::size_t leg_ = 0;
  Time leg_start_;
  Time leg_end_;
  LocalState from_;                  ///< at the beginning of the leg
  std::optional<double> docking_m_;  ///< range on the docking axis at the beginning of the leg, after a close
  PlannedPace pace_;
  std::optional<FreeFlight> flight_;  ///< of a drift
  Mat3 R_LC_fixed_ = Mat3::Identity();
};

}  // namespace relnav::hil
