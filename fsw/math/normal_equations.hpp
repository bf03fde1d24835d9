#pragma once
#include <algorithm>
#include <array>
#include <cstddef>

#include <Eigen/Core>

#include "fsw/base/status.hpp"
#include "fsw/math/pair.hpp"
#include "fsw/math/scalar.hpp"

namespace relnav {

/// Normal equations of a small weighted least-squares problem, N unknowns, for any scalar. Rows come whitened, one by one or
/// (Row = Pair<S>) two by two.
template <typename S, int N, typename Row = S>
class NormalEquations {
  static constexpr std::size_t n = static_cast<std::size_t>(N);

 public:
  using Vector = Eigen::Matrix<S, N, 1>;
  using Matrix = Eigen::Matrix<S, N, N>;

  void clear() {
    A_.fill(Row());
    b_.fill(Row());
    r2_ = Row();
    added_ = S(0);
  }
  /// Adds the row or rows `j` d = r.
  void add(const std::array<Row, n>& j, const Row& r) {
    std::size_t at = 0;
    for (std::size_t c = 0; c < n; ++c) {
      for (std::size_t k = c; k < n; ++k) A_[at++] += j[k] * j[c];
      b_[c] += j[c] * r;
    }
    r2_ += r * r;
  }
  void add_cost(const S& cost) { added_ += cost; }
  /// Sum of the squared residuals, and of what was added.
  [[nodiscard]] S cost() const { return total(r2_) + added_; }

  /// Factorises A = L D L'. rank_deficient: a pivot is at most `least_pivot` of its diagonal element; not_finite: a number
  /// left the range of S. A pivot under `least_divisor` is enlarged to it: the solution is shorter, and leads down still.
  Status factorise(const S& least_pivot, const S& least_divisor = S(0)) {
    load();
    bool convex = true;
    const Status status = factorise_loaded(least_pivot, least_divisor, convex);
    return convex ? status : Status::rank_deficient;
  }
  /// The same of A + curvature. Not `convex`: a pivot was negative, and has changed its sign. The solution leads down still,
  /// and away from where the cost has a maximum in that direction.
  Status factorise(const Matrix& curvature, const S& least_pivot, const S& least_divisor, bool& convex) {
    load();
    for (std::size_t c = 0; c < n; ++c) {
      for (std::size_t r = c; r < n; ++r) {
        L_[r][c] += curvature(static_cast<Eigen::Index>(r), static_cast<Eigen::Index>(c));
      }
    }
    convex = true;
    return factorise_loaded(least_pivot, least_divisor, convex);
  }
  /// Of the factorised system. gain: d'b, by which half the cost falls in the quadratic model, times two.
  [[nodiscard]] Vector solution(S& gain) const {
    std::array<S, n> y;
    gain = S(0);
    for (std::size_t r = 0; r < n; ++r) {
      S sum = total(b_[r]);
      for (std::size_t k = 0; k < r; ++k) sum -= L_[r][k] * y[k];
      y[r] = sum;
      gain += sum * (sum * inverse_[r]);  // in this order inside the range of the cost
    }
    Vector d;
    for (std::size_t i = n; i > 0; --i) {
      const std::size_t r = i - 1;
      S sum = y[r] * inverse_[r];
      for (std::size_t k = i; k < n; ++k) sum -= L_[k][r] * d(static_cast<Eigen::Index>(k));
      d(static_cast<Eigen::Index>(r)) = sum;
    }
    return d;
  }
  /// Of the factorised matrix: L^-T D^-1 L^-1, symmetric.
  [[nodiscard]] Matrix inverse() const {
    std::array<std::array<S, n>, n> M{};  // L^-1, unit lower triangle
    for (std::size_t c = 0; c < n; ++c) {
      M[c][c] = S(1);
      for (std::size_t r = c + 1; r < n; ++r) {
        S sum = -L_[r][c];
        for (std::size_t k = c + 1; k < r; ++k) sum -= L_[r][k] * M[k][c];
        M[r][c] = sum;
      }
    }
    Matrix P;
    for (std::size_t a = 0; a < n; ++a) {
      for (std::size_t b = a; b < n; ++b) {
        S sum(0);
        for (std::size_t k = b; k < n; ++k) sum += M[k][a] * inverse_[k] * M[k][b];
        P(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(b)) = sum;
        P(static_cast<Eigen::Index>(b), static_cast<Eigen::Index>(a)) = sum;
      }
    }
    return P;
  }

 private:
  /// Of a pivot that has changed its sign, over the diagonal element: a step must stay in the range of numbers.
  static constexpr double least_turned = 0.01;

  [[nodiscard]] static const S& total(const S& row) { return row; }
  [[nodiscard]] static S total(const Pair<S>& rows) { return rows.first() + rows.second(); }

  void load() {
    std::size_t at = 0;
    for (std::size_t c = 0; c < n; ++c) {
      for (std::size_t r = c; r < n; ++r) L_[r][c] = total(A_[at++]);
      diagonal_[c] = L_[c][c];
    }
  }
  Status factorise_loaded(const S& least_pivot, const S& least_divisor, bool& convex) {
#pragma GCC unroll 6
    for (std::size_t c = 0; c < n; ++c) {
      S pivot = L_[c][c];
      if (pivot < S(0)) {
        convex = false;
        pivot = std::max(-pivot, S(least_turned) * diagonal_[c]);
      }
      if (!(pivot > least_pivot * diagonal_[c])) return Status::rank_deficient;
      inverse_[c] = S(1) / std::max(pivot, least_divisor);
      if (!is_sound(inverse_[c])) return Status::not_finite;
      // What is to the right and below, less this column's part.
      std::array<S, n> column;
#pragma GCC unroll 6
      for (std::size_t r = c + 1; r < n; ++r) {
        column[r] = L_[r][c];
        L_[r][c] = column[r] * inverse_[c];
#pragma GCC unroll 6
        for (std::size_t k = c + 1; k <= r; ++k) L_[r][k] -= L_[r][c] * column[k];
      }
    }
    return Status::ok;
  }

  std::array<Row, n*(n + 1) / 2> A_{};  ///< lower triangle, column by column
  std::array<Row, n> b_{};
  std::array<std::array<S, n>, n> L_;  ///< under the diagonal
  std::array<S, n> inverse_;           ///< of D, the pivots
  std::array<S, n> diagonal_;          ///< of A
  Row r2_{};
  S added_{0};
};

}  // namespace relnav
