#pragma once
#include <optional>

#include "fsw/base/time.hpp"
#include "hil/dynamics/free_flight.hpp"
#include "hil/dynamics/lvlh.hpp"

namespace relnav::hil {

/// A spacecraft's orbit and local frame over time: closed form, integrated with J2, or, without elements, at rest in the
/// origin with L = I.
class ReferenceOrbit {
 public:
  struct Now {
    InertialState state;
    Turning il;  ///< L against I
  };

  ReferenceOrbit(const std::optional<OrbitElements>& elements, Gravity gravity)
      : elements_(elements), gravity_(gravity) {
    if (gravity == Gravity::oblate) flight_.emplace(gravity, orbit_state(*elements, 0.0), Time{0}, 0.0, 0);
  }

  /// Times must not go back.
  [[nodiscard]] Now at(Time time) {
    if (!elements_) return {};
    const InertialState state =
        flight_ ? flight_->at(time) : orbit_state(*elements_, static_cast<double>(time.ns) * 1e-9);
    return {state, local_frame(state, gravity_)};
  }
  [[nodiscard]] Gravity gravity() const { return gravity_; }

 private:
  std::optional<OrbitElements> elements_;
  Gravity gravity_;
  std::optional<FreeFlight> flight_;
};

}  // namespace relnav::hil
