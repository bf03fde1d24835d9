#pragma once
#include <algorithm>
#include <cmath>

#include "fsw/math/types.hpp"

namespace relnav::test {

/// d f / d x by central differences, f: Mat<Cols> -> Mat<Rows>. Error: step^2 f''' / 6 + epsilon |f| / step.
template <int Rows, int Cols, typename Function>
[[nodiscard]] Mat<Rows, Cols> numeric_jacobian(const Function& f, const Mat<Cols>& x, double step) {
  Mat<Rows, Cols> J;
  for (int c = 0; c < Cols; ++c) {
    Mat<Cols> plus = x;
    Mat<Cols> minus = x;
    plus[c] += step;
    minus[c] -= step;
    const Mat<Rows> difference = f(plus) - f(minus);
    J.col(c) = difference / (plus[c] - minus[c]);
  }
  return J;
}

/// Largest difference between the elements, relative to the largest element (or to 1, if that is larger).
/// Infinite when either side holds a value that is not finite, so that a NaN never passes.
template <int Rows, int Cols>
[[nodiscard]] double relative_difference(const Mat<Rows, Cols>& actual, const Mat<Rows, Cols>& expected) {
  double size = 1.0;
  double difference = 0.0;
  for (int r = 0; r < Rows; ++r) {
    for (int c = 0; c < Cols; ++c) {
      if (!std::isfinite(actual(r, c)) || !std::isfinite(expected(r, c))) return HUGE_VAL;
      size = std::max(size, std::fabs(expected(r, c)));
      difference = std::max(difference, std::fabs(actual(r, c) - expected(r, c)));
    }
  }
  return difference / size;
}

/// An analytic Jacobian against the numeric one at x: relative_difference.
template <int Rows, int Cols, typename Function>
[[nodiscard]] double jacobian_error(const Mat<Rows, Cols>& analytic, const Function& f, const Mat<Cols>& x,
                                    double step = 1e-6) {
  return relative_difference<Rows, Cols>(analytic, numeric_jacobian<Rows, Cols>(f, x, step));
}

}  // namespace relnav::test
