#pragma once
#include <array>
#include <cmath>
#include <cstddef>

namespace relnav::vision {

/// Normal equations of the fit of a light spot (u, v, amplitude, half width, background, half length of the path), solved by Cholesky.
struct SpotNormal {
  static constexpr std::size_t parameters = 6;
  using Vector = std::array<double, parameters>;

  std::array<Vector, parameters> matrix{};  // lower triangle
  Vector right{};

  void add(const Vector& row, double residual, double weight) {
    for (std::size_t r = 0; r < parameters; ++r) {
      const double weighted = weight * row[r];
      for (std::size_t c = 0; c <= r; ++c) matrix[r][c] += weighted * row[c];
      right[r] += weighted * residual;
    }
  }
  /// Replaces the matrix by its factor; false when it is not well determined.
  [[nodiscard]] bool factorise() {
    for (std::size_t c = 0; c < parameters; ++c) {
      double pivot = matrix[c][c];
      const double least = 1e-9 * pivot;
      for (std::size_t k = 0; k < c; ++k) pivot -= matrix[c][k] * matrix[c][k];
      if (!(pivot > least && pivot > 0.0)) return false;
      matrix[c][c] = std::sqrt(pivot);
      for (std::size_t r = c + 1; r < parameters; ++r) {
        double sum = matrix[r][c];
        for (std::size_t k = 0; k < c; ++k) sum -= matrix[r][k] * matrix[c][k];
        matrix[r][c] = sum / matrix[c][c];
      }
    }
    return true;
  }
  /// After factorise().
  [[nodiscard]] Vector solve(Vector x) const {
    for (std::size_t r = 0; r < parameters; ++r) {
      for (std::size_t k = 0; k < r; ++k) x[r] -= matrix[r][k] * x[k];
      x[r] /= matrix[r][r];
    }
    for (std::size_t i = parameters; i-- > 0;) {
      for (std::size_t k = i + 1; k < parameters; ++k) x[i] -= matrix[k][i] * x[k];
      x[i] /= matrix[i][i];
    }
    return x;
  }
};

}  // namespace relnav::vision
