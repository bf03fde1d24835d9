#pragma once
#include <array>

#include "fsw/attitude/msr.hpp"
#include "fsw/base/status.hpp"
#include "fsw/math/normal_equations.hpp"

namespace relnav {

/// One observation, linearised: whitened residual r (observed minus predicted) and its Jacobian with respect to the point
/// p_C0 = X_r + t, X_r = R_CT p_T.
template <typename S>
struct PoseRow {
  Eigen::Matrix<S, 3, 1> X_r;
  Eigen::Matrix<S, 2, 3> J;
  Eigen::Matrix<S, 2, 1> r;
  S extra_cost = S(0);  ///< cost beyond r'r, of a robust loss
};

/// When to stop. Lengths are in the unit of t.
template <typename S>
struct IterationLimits {
  int max_iterations = 100;
  S gain;                 ///< converged once a step improves the cost by less: with whitened rows, squared sigmas
  S step;                 ///< or once no component of a step exceeds this (half angle in rad, length)
  S cost_slack;           ///< rounding error of the cost, relative and absolute
  S least_pivot;          ///< under which the normal equations count as singular, relative
  S fair_gain = S(0);     ///< good enough when max_iterations are over
  bool switching = true;  ///< false: stay in the first set, to show what MSR is for
};

/// Iterated least squares for a pose over Rodrigues parameters with MSR: Yue, Hou 2010, (8)-(28), as in
/// cooperative-mono.md. Per feature A = J [2 [X_r x] | I] against the error state [dg dt]; solve, g <- dg * g, t <- t + dt,
/// switch if due, until both corrections are small. Equivalent to Gauss-Newton on the maximum-likelihood cost. Beyond the
/// paper: a step that raises the cost is taken back and damped (Levenberg), and turns at most by about 60 deg.
/// S: double, float or Fixed.
template <typename S>
class PoseIteration {
 public:
  using Vector = Eigen::Matrix<S, 3, 1>;
  using Covariance = Eigen::Matrix<S, 6, 6>;

  GibbsSet<S> attitude;
  Vector t = Vector::Zero();

  /// `row_of(i, R_CT, t, row)` gives the i-th of `count` observations, or an error that ends the solution when it comes at
  /// the start and shortens the step later. ok; too_few_features: fewer than 3; rank_deficient; no_convergence; what
  /// row_of says.
  template <typename RowOf>
  Status solve(int count, const RowOf& row_of, const IterationLimits<S>& limits) {
    iterations_ = 0;
    if (count < 3) return Status::too_few_features;
    Status status = linearise(count, row_of);
    if (status != Status::ok) return status;
    S damping(0);
    Step d_plain;
    S gain_plain(0);
    S gain(0);
    S next_factor(1);
    bool plain = false;  // the last step was one as solved, taken, and is d_plain
    for (iterations_ = 1; iterations_ <= limits.max_iterations; ++iterations_) {
      status = equations_.factorise(damping, limits.least_pivot);
      if (status != Status::ok) return status;
      Step d = equations_.solution(gain);
      // The last step needs no look back: it is inside the noise, and so is what it could spoil.
      const bool converged = gain < limits.gain || is_small(d, limits.step);
      // Steps that shrink slowly (two minima about to merge: a plane seen face on) go on like a geometric series: its sum.
      S factor = next_factor;
      next_factor = S(1);
      const S rate = plain ? equations_.descent(d_plain) / gain_plain : S(0);
      if (magnitude(rate) > S(slow_rate)) factor = S(1) / (S(1) - (rate < S(most_rate) ? rate : S(most_rate)));
      d *= factor;
      const S kept = shortening(d, limits.switching);
      d *= kept;
      plain = !(damping > S(0)) && !(factor < S(1)) && !(factor > S(1)) && !(kept < S(1)) && gain > S(0);
      d_plain = d;
      gain_plain = gain;
      const GibbsSet<S> attitude_before = attitude;
      const Vector t_before = t;
      const NormalEquations<S, 6> equations_before = equations_;
      apply(d, limits.switching);
      if (converged && !(damping > S(0))) return Status::ok;
      status = linearise(count, row_of);
      const S& before = equations_before.cost();
      if (status == Status::ok && equations_.cost() <= before + limits.cost_slack * (S(1) + before)) {
        damping = damping > S(least_damping) ? damping * S(0.1) : S(0);
        continue;
      }
      // Too far, seen by the slope where it led: as far as the secant says. Damping is for what that does not help.
      const S overshoot = plain && status == Status::ok ? -equations_.descent(d) / gain : S(0);
      attitude = attitude_before;
      t = t_before;
      equations_ = equations_before;
      plain = false;
      if (overshoot > S(0) && overshoot < S(most_overshoot)) {
        next_factor = S(1) / (S(1) + overshoot);
        continue;
      }
      damping = damping > S(0) ? damping * S(10.0) : S(first_damping);
      if (damping > S(most_damping)) return Status::no_convergence;
    }
    iterations_ = limits.max_iterations;
    return !(damping > S(fair_damping)) && gain < limits.fair_gain ? Status::ok : Status::no_convergence;
  }
  /// Cost and covariance where attitude and t stand. rank_deficient, or what row_of says.
  template <typename RowOf>
  Status assess(int count, const RowOf& row_of, const S& least_pivot) {
    iterations_ = 0;
    if (count < 3) return Status::too_few_features;
    const Status status = linearise(count, row_of);
    return status == Status::ok ? equations_.factorise(S(0), least_pivot) : status;
  }
  [[nodiscard]] int iterations() const { return iterations_; }
  /// Sum of squared whitened residuals at the last linearisation.
  [[nodiscard]] const S& cost() const { return equations_.cost(); }
  /// Of [dt dphi], R_true = Exp([dphi x]) R, from the last factorisation.
  [[nodiscard]] Covariance covariance() const {
    // Unknowns are [dg dt] with dphi = -2 dg.
    const Covariance P = equations_.inverse();
    Covariance out;
    for (int a = 0; a < 3; ++a) {
      for (int b = 0; b < 3; ++b) {
        out(a, b) = P(a + 3, b + 3);
        out(a, b + 3) = -(P(a + 3, b) + P(a + 3, b));
        out(a + 3, b) = -(P(a, b + 3) + P(a, b + 3));
        const S two = P(a, b) + P(a, b);
        out(a + 3, b + 3) = two + two;
      }
    }
    return out;
  }

 private:
  using Step = typename NormalEquations<S, 6>::Vector;
  static constexpr double least_damping = 1e-6;
  static constexpr double first_damping = 1e-3;
  static constexpr double most_damping = 1e6;
  static constexpr double fair_damping = 0.1;    ///< up to which a small gain still means a near optimum
  static constexpr double slow_rate = 0.5;       ///< of successive steps, from which on they are summed
  static constexpr double most_rate = 0.99;      ///< at most 100 steps in one
  static constexpr double most_overshoot = 4.0;  ///< of a step's gain; beyond, far from the optimum, it is damped
  static constexpr double largest_dg = 0.5;  ///< of a component of a step, and of dg'g: keeps (10) away from its pole

  template <typename RowOf>
  Status linearise(int count, const RowOf& row_of) {
    equations_.clear();
    const Eigen::Matrix<S, 3, 3> R_CT = attitude.dcm();
    PoseRow<S> row;
    for (int i = 0; i < count; ++i) {
      const Status status = row_of(i, R_CT, t, row);
      if (status != Status::ok) return status;
      for (int k = 0; k < 2; ++k) {
        const S a = row.J(k, 0), b = row.J(k, 1), c = row.J(k, 2);
        // a' 2 [X_r x]
        const S x = b * row.X_r(2) - c * row.X_r(1);
        const S y = c * row.X_r(0) - a * row.X_r(2);
        const S z = a * row.X_r(1) - b * row.X_r(0);
        equations_.add({x + x, y + y, z + z, a, b, c}, row.r(k));
      }
      equations_.add_cost(row.extra_cost);
    }
    return Status::ok;
  }
  [[nodiscard]] static S magnitude(const S& value) { return value < S(0) ? -value : value; }
  /// Share of a step that may be taken.
  [[nodiscard]] S shortening(const Step& d, bool switching) const {
    S largest(0);
    S product(0);
    for (int k = 0; k < 3; ++k) {
      largest = magnitude(d(k)) > largest ? magnitude(d(k)) : largest;
      product += d(k) * attitude.g(k);
    }
    if (switching && product > largest) largest = product;  // without it g has no bound and the pole is met anyway
    return largest > S(largest_dg) ? S(largest_dg) / largest : S(1);
  }
  [[nodiscard]] static bool is_small(const Step& d, const S& bound) {
    for (int k = 0; k < 6; ++k) {
      if (!(magnitude(d(k)) <= bound)) return false;
    }
    return true;
  }
  void apply(const Step& d, bool switching) {
    attitude.correct(Vector(d(0), d(1), d(2)));
    if (switching) static_cast<void>(attitude.switch_if_due());
    for (int k = 0; k < 3; ++k) t(k) += d(k + 3);
  }

  NormalEquations<S, 6> equations_;
  int iterations_ = 0;
};

}  // namespace relnav
