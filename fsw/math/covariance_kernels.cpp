#include "fsw/math/covariance_kernels.hpp"

#include <cmath>
#include <cstddef>
#include <cstring>
#include <limits>

namespace relnav {
namespace {

// The widest vector the target has in registers. gcc takes wider ones through memory, at 18 times the cost
// (4440 against 243 us for the downdate). Each lane is one element: width never changes the bits.
#if defined(__AVX__)
using Vec = double __attribute__((vector_size(32)));
#elif defined(__SSE2__) || defined(__aarch64__)
using Vec = double __attribute__((vector_size(16)));
#else
using Vec = double;
#endif

template <typename T, int N>
using Array = T[static_cast<std::size_t>(N)];

template <typename V>
inline constexpr int lanes = static_cast<int>(sizeof(V) / sizeof(double));

template <typename V>
[[gnu::always_inline]] inline void load(V& v, const double* p) {
  std::memcpy(&v, p, sizeof(V));  // any alignment
}
template <typename V>
[[gnu::always_inline]] inline void store(double* p, const V& v) {
  std::memcpy(p, &v, sizeof(V));
}

/// Cols columns x (Vectors x lanes) rows of a matrix, held in registers.
template <typename V, int Cols, int Vectors>
struct Tile {
  static constexpr int rows = Vectors * lanes<V>;
  Array<Array<V, Vectors>, Cols> acc;

  [[gnu::always_inline]] inline void load_from(const double* c, int ld) {
#pragma GCC unroll 4
    for (int j = 0; j < Cols; ++j) {
#pragma GCC unroll 4
      for (int v = 0; v < Vectors; ++v) load(acc[j][v], c + j * ld + v * lanes<V>);
    }
  }
  [[gnu::always_inline]] inline void store_to(double* c, int ld) const {
#pragma GCC unroll 4
    for (int j = 0; j < Cols; ++j) {
#pragma GCC unroll 4
      for (int v = 0; v < Vectors; ++v) store(c + j * ld + v * lanes<V>, acc[j][v]);
    }
  }
  /// acc(:, j) -= sum over k = 0..depth-1, in this order, of a(:, k) w(j, k).
  [[gnu::always_inline]] inline void subtract_product(const double* a, int lda, const double* w, int ldw, int depth) {
    for (int k = 0; k < depth; ++k) {
      Array<V, Vectors> ak;
#pragma GCC unroll 4
      for (int v = 0; v < Vectors; ++v) load(ak[v], a + v * lanes<V>);
#pragma GCC unroll 4
      for (int j = 0; j < Cols; ++j) {
        const double wj = w[j];
#pragma GCC unroll 4
        for (int v = 0; v < Vectors; ++v) acc[j][v] -= ak[v] * wj;
      }
      a += lda;
      w += ldw;
    }
  }
  /// acc := acc L^-T for the lower triangle L of a Cols x Cols block; inverse = 1 / diagonal.
  [[gnu::always_inline]] inline void solve_block(const double* L, int ld, const double* inverse) {
#pragma GCC unroll 4
    for (int j = 0; j < Cols; ++j) {
#pragma GCC unroll 4
      for (int k = 0; k < j; ++k) {
        const double l = L[j + k * ld];
#pragma GCC unroll 4
        for (int v = 0; v < Vectors; ++v) acc[j][v] -= acc[k][v] * l;
      }
      const double scale = inverse[j];
#pragma GCC unroll 4
      for (int v = 0; v < Vectors; ++v) acc[j][v] *= scale;
    }
  }
};

/// Calls body(tag, row) with the tile type that fits, from `begin` to `end`.
template <int Cols, typename Body>
[[gnu::always_inline]] inline void over_rows(int begin, int end, Body body) {
  int i = begin;
  for (; i + 2 * lanes<Vec> <= end; i += 2 * lanes<Vec>) body.template operator()<Tile<Vec, Cols, 2>>(i);
  for (; i + lanes<Vec> <= end; i += lanes<Vec>) body.template operator()<Tile<Vec, Cols, 1>>(i);
  for (; i < end; ++i) body.template operator()<Tile<double, Cols, 1>>(i);
}

constexpr int panel = 4;  // columns of a tile

/// Rows [begin, end) of columns j..j+Cols-1 of X := (X - X(:, 0..j-1) L(j.., 0..j-1)') L(j.., j..)^-T.
template <int Cols>
void solve_panel(ConstMatrixView L, int j, MatrixView X, int begin, int end, const double* inverse) {
  over_rows<Cols>(begin, end, [&]<typename T>(int i) {
    T tile;
    double* const x = X.col(j) + i;
    tile.load_from(x, X.ld);
    tile.subtract_product(X.data + i, X.ld, L.data + j, L.ld, j);
    tile.solve_block(&L(j, j), L.ld, inverse);
    tile.store_to(x, X.ld);
  });
}

void solve_panel(ConstMatrixView L, int j, int width, MatrixView X, int begin, int end) {
  double inverse[panel] = {};
  for (int t = 0; t < width; ++t) inverse[t] = 1.0 / L(j + t, j + t);
  switch (width) {
    case 4: solve_panel<4>(L, j, X, begin, end, inverse); break;
    case 3: solve_panel<3>(L, j, X, begin, end, inverse); break;
    case 2: solve_panel<2>(L, j, X, begin, end, inverse); break;
    default: solve_panel<1>(L, j, X, begin, end, inverse); break;
  }
}

/// Columns j..j+Cols-1 of P -= B B', rows j.. on.
template <int Cols>
void downdate_panel(MatrixView P, ConstMatrixView B, int j) {
  over_rows<Cols>(j, P.rows, [&]<typename T>(int i) {
    T tile;
    double* const p = P.col(j) + i;
    tile.load_from(p, P.ld);
    tile.subtract_product(B.data + i, B.ld, B.data + j, B.ld, B.cols);
    tile.store_to(p, P.ld);
  });
}

/// Zero of either sign; false for NaN, which must spread.
constexpr bool is_zero(double x) { return x <= 0.0 && x >= 0.0; }

/// Nonzero columns of a pair of rows of H, in ascending order.
struct Terms {
  int count = 0;
  int column[motion_states + 6];
  double first[motion_states + 6];
  double second[motion_states + 6];

  explicit Terms(const SparseRowPair& pair) {
    for (int c = 0; c < motion_states; ++c) add(c, pair.motion[0][c], pair.motion[1][c]);
    for (int c = 0; c < pair.feature_size; ++c) add(pair.feature_offset + c, pair.feature[0][c], pair.feature[1][c]);
  }

 private:
  void add(int c, double a, double b) {
    if (is_zero(a) && is_zero(b)) return;
    column[count] = c;
    first[count] = a;
    second[count] = b;
    ++count;
  }
};

void check_pair(const SparseRowPair& pair, int n) {
  RELNAV_ASSERT(pair.feature_size >= 0 && pair.feature_size <= 6);
  RELNAV_ASSERT(pair.feature_size == 0 ||
                (pair.feature_offset >= motion_states && pair.feature_offset + pair.feature_size <= n));
}

/// Columns first..first+Size-1 of P, rows [begin, end): P(r, first + i) := sum over k of J(i, k) P(r, first + k).
template <int Size, typename Matrix>
void map_columns(MatrixView P, int first, int begin, int end, const Matrix& J) {
  const auto rows = [&]<typename V>(int r) {
    Array<V, Size> in;
    for (int k = 0; k < Size; ++k) load(in[k], P.col(first + k) + r);
    for (int i = 0; i < Size; ++i) {
      V sum = in[0] * J(i, 0);
      for (int k = 1; k < Size; ++k) sum += in[k] * J(i, k);
      store(P.col(first + i) + r, sum);
    }
  };
  int r = begin;
  for (; r + lanes<Vec> <= end; r += lanes<Vec>) rows.template operator()<Vec>(r);
  for (; r < end; ++r) rows.template operator()<double>(r);
}

void copy_to_rows(MatrixView P, int first, int size, int begin, int end) {
  for (int c = begin; c < end; ++c) {
    for (int i = 0; i < size; ++i) P(first + i, c) = P(c, first + i);
  }
}

/// The block on the diagonal becomes (D + D') / 2 with D = J P_bb J'.
template <int Size, typename Matrix>
void map_diagonal_block(MatrixView P, int first, const Matrix& J) {
  Array<Array<double, Size>, Size> half;
  Array<Array<double, Size>, Size> full;
  for (int i = 0; i < Size; ++i) {
    for (int j = 0; j < Size; ++j) {
      double sum = J(i, 0) * P(first, first + j);
      for (int k = 1; k < Size; ++k) sum += J(i, k) * P(first + k, first + j);
      half[i][j] = sum;
    }
  }
  for (int i = 0; i < Size; ++i) {
    for (int j = 0; j < Size; ++j) {
      double sum = half[i][0] * J(j, 0);
      for (int k = 1; k < Size; ++k) sum += half[i][k] * J(j, k);
      full[i][j] = sum;
    }
  }
  for (int j = 0; j < Size; ++j) {
    for (int i = 0; i < Size; ++i) P(first + i, first + j) = 0.5 * (full[i][j] + full[j][i]);
  }
}

}  // namespace

void multiply_p_ht(ConstMatrixView P, std::span<const SparseRowPair> rows, MatrixView PHt) {
  const int n = P.rows;
  RELNAV_ASSERT(P.cols == n && n >= motion_states && PHt.rows == n && PHt.cols == 2 * static_cast<int>(rows.size()));
  int c = 0;
  for (const SparseRowPair& pair : rows) {
    check_pair(pair, n);
    const Terms terms(pair);
    double* const first = PHt.col(c);
    double* const second = PHt.col(c + 1);
    const auto block = [&]<typename V, int Vectors>(int i) {
      Array<V, Vectors> sum[2] = {};
      for (int t = 0; t < terms.count; ++t) {
        const double* const p = P.col(terms.column[t]) + i;
#pragma GCC unroll 4
        for (int v = 0; v < Vectors; ++v) {
          V x;
          load(x, p + v * lanes<V>);
          sum[0][v] += x * terms.first[t];
          sum[1][v] += x * terms.second[t];
        }
      }
#pragma GCC unroll 4
      for (int v = 0; v < Vectors; ++v) {
        store(first + i + v * lanes<V>, sum[0][v]);
        store(second + i + v * lanes<V>, sum[1][v]);
      }
    };
    int i = 0;
    for (; i + 4 * lanes<Vec> <= n; i += 4 * lanes<Vec>) block.template operator()<Vec, 4>(i);
    for (; i + lanes<Vec> <= n; i += lanes<Vec>) block.template operator()<Vec, 1>(i);
    for (; i < n; ++i) block.template operator()<double, 1>(i);
    c += 2;
  }
}

void innovation_covariance(std::span<const SparseRowPair> rows, ConstMatrixView PHt, std::span<const double> r_diag,
                           MatrixView S) {
  const int m = 2 * static_cast<int>(rows.size());
  RELNAV_ASSERT(PHt.cols == m && S.rows == m && S.cols == m && static_cast<int>(r_diag.size()) == m);
  int i = 0;
  for (const SparseRowPair& pair : rows) {
    check_pair(pair, PHt.rows);
    const Terms terms(pair);
    for (int j = 0; j < i + 2; ++j) {
      const double* const column = PHt.col(j);
      double first = 0.0;
      double second = 0.0;
      for (int t = 0; t < terms.count; ++t) {
        const double x = column[terms.column[t]];
        first += terms.first[t] * x;
        second += terms.second[t] * x;
      }
      if (j <= i) S(i, j) = first;
      S(i + 1, j) = second;
    }
    S(i, i) += r_diag[static_cast<std::size_t>(i)];
    S(i + 1, i + 1) += r_diag[static_cast<std::size_t>(i + 1)];
    i += 2;
  }
}

Status cholesky_lower(MatrixView S) {
  const int m = S.rows;
  RELNAV_ASSERT(S.cols == m);
  for (int j = 0; j < m; j += panel) {
    const int width = m - j < panel ? m - j : panel;
    // The block on the diagonal element by element, the rows below it as a triangular solve with it.
    for (int c = j; c < j + width; ++c) {
      for (int r = c; r < j + width; ++r) {
        double sum = S(r, c);
        for (int k = 0; k < c; ++k) sum -= S(r, k) * S(c, k);
        if (r == c) {
          if (!(sum > 0.0 && sum <= std::numeric_limits<double>::max())) return Status::not_positive_definite;
          S(c, c) = std::sqrt(sum);
        } else {
          S(r, c) = sum * (1.0 / S(c, c));
        }
      }
    }
    solve_panel(S, j, width, S, j + width, m);
  }
  return Status::ok;
}

void solve_right_transposed(ConstMatrixView L, MatrixView B) {
  const int m = L.rows;
  RELNAV_ASSERT(L.cols == m && B.cols == m);
  constexpr int block = 64;  // rows whose m = 60 columns stay in a 32 KiB cache between panels
  for (int begin = 0; begin < B.rows; begin += block) {
    const int end = B.rows - begin < block ? B.rows : begin + block;
    for (int j = 0; j < m; j += panel) solve_panel(L, j, m - j < panel ? m - j : panel, B, begin, end);
  }
}

void solve_lower(ConstMatrixView L, std::span<double> x) {
  const int m = L.rows;
  RELNAV_ASSERT(L.cols == m && static_cast<int>(x.size()) == m);
  double* const v = x.data();
  for (int j = 0; j < m; ++j) {
    v[j] /= L(j, j);
    const double* const l = L.col(j);
    for (int i = j + 1; i < m; ++i) v[i] -= l[i] * v[j];
  }
}

void state_increment(ConstMatrixView B, std::span<const double> y, std::span<double> dx) {
  RELNAV_ASSERT(static_cast<int>(y.size()) == B.cols && static_cast<int>(dx.size()) == B.rows);
  double* const x = dx.data();
  for (int i = 0; i < B.rows; ++i) x[i] = 0.0;
  for (int k = 0; k < B.cols; ++k) {
    const double yk = y[static_cast<std::size_t>(k)];
    const double* const b = B.col(k);
    for (int i = 0; i < B.rows; ++i) x[i] += b[i] * yk;
  }
}

void downdate_symmetric(MatrixView P, ConstMatrixView B) {
  const int n = P.rows;
  RELNAV_ASSERT(P.cols == n && B.rows == n);
  int j = 0;
  for (; j + panel <= n; j += panel) downdate_panel<panel>(P, B, j);
  for (; j < n; ++j) downdate_panel<1>(P, B, j);
  mirror_lower(P);
}

void mirror_lower(MatrixView P) {
  const int n = P.rows;
  RELNAV_ASSERT(P.cols == n);
  constexpr int block = 8;  // a cache line of doubles each way
  for (int c0 = 0; c0 < n; c0 += block) {
    const int c1 = n - c0 < block ? n : c0 + block;
    for (int r0 = c0; r0 < n; r0 += block) {
      const int r1 = n - r0 < block ? n : r0 + block;
      for (int r = r0; r < r1; ++r) {
        double* const target = P.col(r);
        for (int c = c0; c < c1 && c < r; ++c) target[c] = P(r, c);
      }
    }
  }
}

void predict_motion(MatrixView P, const Mat<motion_states, motion_states>& F,
                    const Mat<motion_states, motion_states>& Q) {
  const int n = P.rows;
  RELNAV_ASSERT(P.cols == n && n >= motion_states);
  map_diagonal_block<motion_states>(P, 0, F);
  for (int j = 0; j < motion_states; ++j) {
    for (int i = 0; i < motion_states; ++i) P(i, j) += 0.5 * (Q(i, j) + Q(j, i));
  }
  map_columns<motion_states>(P, 0, motion_states, n, F);
  copy_to_rows(P, 0, motion_states, motion_states, n);
}

void transform_block(MatrixView P, int offset, const Mat3& J) {
  const int n = P.rows;
  RELNAV_ASSERT(P.cols == n && offset >= 0 && offset + 3 <= n);
  map_diagonal_block<3>(P, offset, J);
  map_columns<3>(P, offset, 0, offset, J);
  map_columns<3>(P, offset, offset + 3, n, J);
  copy_to_rows(P, offset, 3, 0, offset);
  copy_to_rows(P, offset, 3, offset + 3, n);
}

}  // namespace relnav
