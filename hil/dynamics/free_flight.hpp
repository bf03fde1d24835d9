#pragma once
#include "hil/dynamics/gravity.hpp"
#include "hil/dynamics/grid_integrator.hpp"
#include "hil/dynamics/orbit.hpp"

namespace relnav::hil {

/// Position and velocity of a point that only gravity and random accelerations move.
struct FreeFlightModel {
  using State = Vec6;  ///< r_I (m), v_I (m/s)
  Gravity gravity = Gravity::point_mass;

  [[nodiscard]] State rates(const State& x, const Vec3& acceleration_I) const {
    State d;
    d << x.tail<3>(), gravity_at(gravity, x.head<3>()) + acceleration_I;
    return d;
  }
  void tidy(State& /*x*/) const {}
};

/// On a grid of 1 s; `density`: of the random acceleration, m/s^1.5.
class FreeFlight {
 public:
  FreeFlight(Gravity gravity, const InertialState& start, Time time, double density, std::uint64_t seed)
      : flight_({gravity}, (Vec6() << start.r_I, start.v_I).finished(), time, Duration{1'000'000'000}, density, seed) {}

  [[nodiscard]] InertialState at(Time time) {
    const Vec6 x = flight_.at(time);
    return {x.head<3>(), x.tail<3>()};
  }

 private:
  GridIntegrator<FreeFlightModel> flight_;
};

}  // namespace relnav::hil
