#pragma once
#include <array>
#include <cstddef>
#include <span>

#include "fsw/base/panic.hpp"
#include "fsw/base/status.hpp"
#include "fsw/math/types.hpp"

namespace relnav {

// Everything of order n^2 in a filter with a full covariance: n states, m measurement rows, n = 252 and m = 60 typical.
// Every element is accumulated in one fixed order, so the bits do not depend on vector width, tile or remainder.
// Mismatched sizes are bugs (RELNAV_ASSERT). Arguments must not overlap. No heap, no alloca.

/// Column-major matrix in somebody else's storage; element (r, c) is data[r + c ld], ld >= rows.
struct ConstMatrixView {
  const double* data = nullptr;
  int rows = 0;
  int cols = 0;
  int ld = 0;
  [[nodiscard]] constexpr const double& operator()(int r, int c) const { return data[r + c * ld]; }
  [[nodiscard]] constexpr const double* col(int c) const { return data + c * ld; }
};

/// As ConstMatrixView, elements writable.
struct MatrixView {
  double* data = nullptr;
  int rows = 0;
  int cols = 0;
  int ld = 0;
  [[nodiscard]] constexpr double& operator()(int r, int c) const { return data[r + c * ld]; }
  [[nodiscard]] constexpr double* col(int c) const { return data + c * ld; }
  constexpr operator ConstMatrixView() const { return {data, rows, cols, ld}; }  // NOLINT(google-explicit-constructor)
};

/// Storage of at most MaxRows x MaxCols, zero at first. Column starts are 64-byte aligned.
template <int MaxRows, int MaxCols>
class MatrixStorage {
  static_assert(MaxRows > 0 && MaxCols > 0);
  static constexpr int whole = (MaxRows + 7) / 8 * 8;

 public:
  /// A power-of-two stride maps all columns to few cache sets: the downdate takes 1.5 times as long.
  static constexpr int leading_dimension = (whole & (whole - 1)) != 0 ? whole : whole + (whole == 8 ? 16 : 8);

  [[nodiscard]] constexpr MatrixView view(int rows, int cols) {
    RELNAV_ASSERT(rows >= 0 && rows <= MaxRows && cols >= 0 && cols <= MaxCols);
    return {data_.data(), rows, cols, leading_dimension};
  }
  [[nodiscard]] constexpr ConstMatrixView view(int rows, int cols) const {
    RELNAV_ASSERT(rows >= 0 && rows <= MaxRows && cols >= 0 && cols <= MaxCols);
    return {data_.data(), rows, cols, leading_dimension};
  }

 private:
  alignas(
      64) std::array<double, static_cast<std::size_t>(leading_dimension) * static_cast<std::size_t>(MaxCols)> data_{};
};

/// States 0..11 are the motion (dense in every measurement row).
inline constexpr int motion_states = 12;

/// Two rows of H: dense in the motion states, and feature_size (0..6) columns from feature_offset (>= 12) on.
struct SparseRowPair {
  int feature_offset = motion_states;
  int feature_size = 0;
  double motion[2][motion_states] = {};
  double feature[2][6] = {};
};

/// PHt = P H', (n x n)(n x m), m = 2 rows.size(). P: both triangles valid. Columns whose two coefficients are 0 are skipped.
void multiply_p_ht(ConstMatrixView P, std::span<const SparseRowPair> rows, MatrixView PHt);

/// Lower triangle of S = H PHt + diag(r), m x m. The strict upper triangle is left alone.
void innovation_covariance(std::span<const SparseRowPair> rows, ConstMatrixView PHt, std::span<const double> r_diag,
                           MatrixView S);

/// S = L L' in place, from and to the lower triangle; the strict upper triangle is neither read nor written.
/// not_positive_definite: a pivot <= 0, NaN or infinite; S is then partly overwritten. Golub & Van Loan, 4th ed., sec. 4.2.
Status cholesky_lower(MatrixView S);

/// B := B L^-T, (n x m)(m x m), in place. L: lower triangle, positive diagonal.
void solve_right_transposed(ConstMatrixView L, MatrixView B);

/// x := L^-1 x, m elements, in place.
void solve_lower(ConstMatrixView L, std::span<double> x);

/// dx := B y, (n x m)(m). With B = P H' L^-T and y = L^-1 z this is the Kalman increment K z.
void state_increment(ConstMatrixView B, std::span<const double> y, std::span<double> dx);

/// P := P - B B', computed on the lower triangle and copied to the upper. P: n x n, both triangles valid; B: n x m.
void downdate_symmetric(MatrixView P, ConstMatrixView B);

/// Copies the strict lower triangle to the upper.
void mirror_lower(MatrixView P);

/// Motion block: P11 := F P11 F' + Q (symmetrised), P12 := F P12, P21 := P12'. Other elements are left alone.
void predict_motion(MatrixView P, const Mat<motion_states, motion_states>& F,
                    const Mat<motion_states, motion_states>& Q);

/// Change of three coordinates x_b := J x_b, b = offset..offset+2: the block becomes J P_bb J' (symmetrised), cross terms J P_bx.
void transform_block(MatrixView P, int offset, const Mat3& J);

}  // namespace relnav
