#pragma once
#include <array>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <utility>

#include "fsw/base/time.hpp"
#include "fsw/math/types.hpp"
#include "hil/scenarios/gaussian.hpp"

namespace relnav::hil {

/// One step of the explicit Runge-Kutta formula of order 7 with 11 stages of Fehlberg, NASA TR R-287, 1968, table X,
/// for dx/dt = rates(x).
template <typename State, typename Rates>
[[nodiscard]] State runge_kutta_7(const State& x, double h, const Rates& rates) {
  static constexpr double a[11][10] = {
      {},
      {2. / 27},
      {1. / 36, 1. / 12},
      {1. / 24, 0, 1. / 8},
      {5. / 12, 0, -25. / 16, 25. / 16},
      {1. / 20, 0, 0, 1. / 4, 1. / 5},
      {-25. / 108, 0, 0, 125. / 108, -65. / 27, 125. / 54},
      {31. / 300, 0, 0, 0, 61. / 225, -2. / 9, 13. / 900},
      {2, 0, 0, -53. / 6, 704. / 45, -107. / 9, 67. / 90, 3},
      {-91. / 108, 0, 0, 23. / 108, -976. / 135, 311. / 54, -19. / 60, 17. / 6, -1. / 12},
      {2383. / 4100, 0, 0, -341. / 164, 4496. / 1025, -301. / 82, 2133. / 4100, 45. / 82, 45. / 164, 18. / 41}};
  static constexpr double b[11] = {41. / 840, 0, 0, 0, 0, 34. / 105, 9. / 35, 9. / 35, 9. / 280, 9. / 280, 41. / 840};
  std::array<State, 11> k;
  State sum = State::Zero();
  for (std::size_t i = 0; i < k.size(); ++i) {
    State at = State::Zero();
    for (std::size_t j = 0; j < i; ++j) at += a[i][j] * k[j];
    k[i] = rates(State(x + h * at));
    sum += b[i] * k[i];
  }
  return x + h * sum;
}

/// Integrates a model on a fixed grid of times from `start` on; what lies between is a shorter step from the grid point
/// before, so that a state does not depend on the times that were asked for. A disturbance (white, of the given
/// density, three axes) is held over a step of the grid.
///
/// Model: `State`, `State rates(state, disturbance) const`, `void tidy(State&) const` after each step.
template <typename Model>
class GridIntegrator {
 public:
  using State = typename Model::State;

  GridIntegrator(Model model, State state, Time start, Duration step, double density, std::uint64_t seed)
      : model_(std::move(model)),
        state_(std::move(state)),
        grid_time_(start),
        step_(step),
        density_(density),
        noise_(seed) {
    draw();
  }

  /// Times must not go back beyond the grid point before the last one.
  [[nodiscard]] State at(Time time) {
    if (time < grid_time_) throw std::invalid_argument("dynamics: time goes back");
    while (time >= grid_time_ + step_) {
      state_ = stepped(step_.seconds());
      grid_time_ = grid_time_ + step_;
      draw();
    }
    return time == grid_time_ ? state_ : stepped((time - grid_time_).seconds());
  }
  [[nodiscard]] const Model& model() const { return model_; }

 private:
  [[nodiscard]] State stepped(double h) const {
    State next = runge_kutta_7(state_, h, [&](const State& x) { return model_.rates(x, disturbance_); });
    model_.tidy(next);
    return next;
  }
  void draw() {
    if (density_ == 0.0) return;
    for (int i = 0; i < 3; ++i) disturbance_(i) = density_ / std::sqrt(step_.seconds()) * noise_.next();
  }

  Model model_;
  State state_;
  Time grid_time_;
  Duration step_;
  double density_ = 0.0;
  Gaussian noise_;
  Vec3 disturbance_ = Vec3::Zero();
};

}  // namespace relnav::hil
