#pragma once
#include <algorithm>
#include <array>

#include "fsw/attitude/msr.hpp"
#include "fsw/base/status.hpp"
#include "fsw/math/normal_equations.hpp"
#include "fsw/math/scalar.hpp"

namespace relnav {

/// One observation, linearised: whitened residual r (observed minus predicted) and its Jacobian with respect to the point
/// p_C0 = X_r + t, X_r = R_CT p_T.
template <typename S>
struct PoseRow {
  Eigen::Matrix<S, 3, 1> X_r;
  Eigen::Matrix<S, 2, 3> J;
  Eigen::Matrix<S, 2, 1> r;
  S extra_cost = S(0);  ///< cost beyond r'r, of a robust loss
  /// How J changes with the point: row j' by -(axis j' + j axis') / depth. Exactly so for a pinhole, with its axis in C0.
  Eigen::Matrix<S, 3, 1> axis;
  S depth;
};

/// Adds what a row's residual contributes to the Hessian of half the cost beyond A'A, for the error state [dt 2dg]: -r h''.
/// With c = J'r and C(dg) X_r = X_r + X_r x 2dg + (2dg (2dg'X_r) - X_r 2dg'2dg) / 2 + ...:
/// -r h'' = W B' + B W' for the image of a point, B = [c, c x X_r], W = [axis, axis x X_r] / depth, and
/// c'X_r I - (c X_r' + X_r c') / 2 for the rotation.
template <typename S>
void add_curvature(const PoseRow<S>& row, Eigen::Matrix<S, 6, 6>& sum) {
  const S inverse = S(1) / row.depth;
  std::array<S, 6> W;
  std::array<S, 6> B;
  for (int k = 0; k < 3; ++k) {
    W[static_cast<std::size_t>(k)] = row.axis(k) * inverse;
    B[static_cast<std::size_t>(k)] = row.J(0, k) * row.r(0) + row.J(1, k) * row.r(1);
  }
  const Eigen::Matrix<S, 3, 1>& X = row.X_r;
  for (std::array<S, 6>* v : {&W, &B}) {
    (*v)[3] = (*v)[1] * X(2) - (*v)[2] * X(1);
    (*v)[4] = (*v)[2] * X(0) - (*v)[0] * X(2);
    (*v)[5] = (*v)[0] * X(1) - (*v)[1] * X(0);
  }
  const S along = B[0] * X(0) + B[1] * X(1) + B[2] * X(2);
  for (int a = 0; a < 6; ++a) {
    for (int b = 0; b < 6; ++b) {
      const auto i = static_cast<std::size_t>(a);
      const auto k = static_cast<std::size_t>(b);
      sum(a, b) += W[i] * B[k] + B[i] * W[k];
      if (a >= 3 && b >= 3) sum(a, b) -= S(0.5) * (B[i - 3] * X(b - 3) + X(a - 3) * B[k - 3]);
    }
    if (a >= 3) sum(a, a) += along;
  }
}

/// When to stop. Lengths are in the unit of t.
template <typename S>
struct IterationLimits {
  int max_iterations = 100;
  S gain;  ///< converged once the next step would improve the cost by less: with whitened rows, squared sigmas
  S least_rate = S(1e-5);  ///< of a next step's gain over this one's, however fast they shrank so far
  S step;                  ///< or once no component of a step exceeds this (angle in rad, length)
  S cost_slack;            ///< rounding error of the cost, relative and absolute
  S least_pivot;           ///< under which the normal equations count as singular, relative
  bool switching = true;   ///< false: stay in the first set, to show what MSR is for
};

/// Iterated least squares for a pose over Rodrigues parameters with MSR: Yue, Hou 2010, (8)-(28), as in
/// cooperative-mono.md. Per feature A = J [I | [X_r x]] against the error state [dt 2dg]; solve, g <- dg * g, t <- t + dt,
/// switch if due, until both corrections are small. Equivalent to Gauss-Newton on the maximum-likelihood cost. Beyond the
/// paper: a step that raises the cost is halved, and turns at most by about 60 deg; once steps shrink slowly or fail (two minima
/// about to merge: a plane seen face on) they are Newton's, with the residuals' curvature. The covariance stays (A'A)^-1.
/// S: double, float or Fixed.
template <typename S>
class PoseIteration {
 public:
  using Vector = Eigen::Matrix<S, 3, 1>;
  using Covariance = Eigen::Matrix<S, 6, 6>;

  GibbsSet<S> attitude;
  Vector t = Vector::Zero();

  /// `row_of(i, R_CT, t, row)` gives the i-th of `count` observations, or an error that ends the solution when it comes at
  /// the start and shortens the step later. ok; too_few_features: fewer than 3; rank_deficient; no_convergence; not_finite: a
  /// number left its range; what row_of says.
  template <typename RowOf>
  Status solve(int count, const RowOf& row_of, const IterationLimits<S>& limits) {
    iterations_ = 0;
    if (count < 3) return Status::too_few_features;
    curved_ = false;
    Status status = linearise(count, row_of);
    if (status != Status::ok) return status;
    S gain_before(0);
    while (iterations_ < limits.max_iterations) {  // bound: max_iterations, counted inside
      bool convex = true;
      S gain;
      Step d;
      bool newton =
          curved_ && equations_.factorise(curvature_, limits.least_pivot, least_divisor, convex) == Status::ok;
      if (newton) {
        d = equations_.solution(gain);
        newton = is_sound(d);  // where two minima merge a pivot is next to nothing
      }
      if (!newton) {
        status = equations_.factorise(limits.least_pivot, least_divisor);
        if (status != Status::ok) return status;
        d = equations_.solution(gain);
        if (!is_sound(d)) return Status::not_finite;
      }
      const S rate = gain < gain_before ? std::max(gain / gain_before, limits.least_rate) : S(1);
      const bool converged = convex && (gain * rate < limits.gain || is_small(d, limits.step));
      if (gain_before > S(0) && rate > S(slow_rate)) curved_ = true;
      gain_before = gain;
      d *= shortening(d, limits.switching);
      const GibbsSet<S> attitude_before = attitude;
      const Vector t_before = t;
      const S most_cost = cost_ + limits.cost_slack * (S(1) + cost_);
      bool lower = false;
      while (!lower && iterations_ < limits.max_iterations) {  // bound: max_iterations, with the loop around
        ++iterations_;
        attitude = attitude_before;
        t = t_before;
        apply(d, limits.switching);
        // The last step needs no look back: it is inside the noise, and so is what it could spoil.
        if (converged) {
          cost_ = std::max(cost_ - gain, S(0));
          return newton ? equations_.factorise(limits.least_pivot, least_divisor) : Status::ok;
        }
        lower = linearise(count, row_of) == Status::ok && is_sound(cost_) && cost_ <= most_cost;
        if (!lower) curved_ = true;
        d *= S(0.5);
      }
    }
    return Status::no_convergence;
  }
  /// Cost and covariance where attitude and t stand. rank_deficient, or what row_of says.
  template <typename RowOf>
  Status assess(int count, const RowOf& row_of, const S& least_pivot) {
    iterations_ = 0;
    curved_ = false;
    if (count < 3) return Status::too_few_features;
    const Status status = linearise(count, row_of);
    return status == Status::ok ? equations_.factorise(least_pivot, least_divisor) : status;
  }
  [[nodiscard]] int iterations() const { return iterations_; }
  /// Sum of squared whitened residuals, and of what robust losses add.
  [[nodiscard]] const S& cost() const { return cost_; }
  /// Of [dt dphi], R_true = Exp([dphi x]) R, from the last factorisation.
  [[nodiscard]] Covariance covariance() const {
    // Unknowns are [dt 2dg] with dphi = -2dg.
    Covariance out = equations_.inverse();
    for (int a = 0; a < 3; ++a) {
      for (int b = 3; b < 6; ++b) {
        out(a, b) = -out(a, b);
        out(b, a) = -out(b, a);
      }
    }
    return out;
  }

 private:
  using Step = typename NormalEquations<S, 6, Pair<S>>::Vector;
  static constexpr S least_divisor = LeastDivisor<S>::value;
  static constexpr double slow_rate = 0.01;  ///< of successive gains: steps that shrink less than tenfold
  static constexpr double largest_dg = 0.5;  ///< of a component of a step, and of dg'g: keeps (10) away from its pole

  template <typename RowOf>
  Status linearise(int count, const RowOf& row_of) {
    equations_.clear();
    if (curved_) curvature_ = Covariance::Constant(S(0));
    const Eigen::Matrix<S, 3, 3> R_CT = attitude.dcm();
    PoseRow<S> row;
    for (int i = 0; i < count; ++i) {
      const Status status = row_of(i, R_CT, t, row);
      if (status != Status::ok) return status;
      const Pair<S> a(row.J(0, 0), row.J(1, 0)), b(row.J(0, 1), row.J(1, 1)), c(row.J(0, 2), row.J(1, 2));
      // J' x X_r
      equations_.add(
          {a, b, c, b * row.X_r(2) - c * row.X_r(1), c * row.X_r(0) - a * row.X_r(2), a * row.X_r(1) - b * row.X_r(0)},
          Pair<S>(row.r(0), row.r(1)));
      equations_.add_cost(row.extra_cost);
      if (curved_) add_curvature(row, curvature_);
    }
    cost_ = equations_.cost();
    return Status::ok;
  }
  [[nodiscard]] static S magnitude(const S& value) { return value < S(0) ? -value : value; }
  /// Share of a step that may be taken.
  [[nodiscard]] S shortening(const Step& d, bool switching) const {
    S largest(0);
    S product(0);
    for (int k = 0; k < 3; ++k) {
      largest = std::max(largest, magnitude(d(k + 3)));
      product += d(k + 3) * attitude.g(k);
    }
    if (switching) largest = std::max(largest, product);  // without it g has no bound and the pole is met anyway
    return largest > S(2.0 * largest_dg) ? S(2.0 * largest_dg) / largest : S(1);
  }
  [[nodiscard]] static bool is_small(const Step& d, const S& bound) {
    for (int k = 0; k < 6; ++k) {
      if (!(magnitude(d(k)) <= bound)) return false;
    }
    return true;
  }
  void apply(const Step& d, bool switching) {
    attitude.correct(Vector(S(0.5) * d(3), S(0.5) * d(4), S(0.5) * d(5)));
    if (switching) static_cast<void>(attitude.switch_if_due());
    for (int k = 0; k < 3; ++k) t(k) += d(k);
  }

  NormalEquations<S, 6, Pair<S>> equations_;
  Covariance curvature_;  ///< of what the equations are of, if curved_
  S cost_{0};
  bool curved_ = false;
  int iterations_ = 0;
};

}  // namespace relnav
