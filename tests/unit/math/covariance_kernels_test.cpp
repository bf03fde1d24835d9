#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "fsw/base/generator.hpp"
#include "fsw/math/covariance_kernels.hpp"
#include "tests/support/dense.hpp"
#include "tests/unit/math/bits.hpp"

#include <CppUTest/TestHarness.h>

using namespace relnav;
using Eigen::MatrixXd;
using test::product;

namespace {

constexpr std::uint64_t seed = 20240917;
constexpr double quiet_nan = std::numeric_limits<double>::quiet_NaN();

double draw(Generator& generator) { return 2.0 * generator.uniform() - 1.0; }

/// A matrix inside a larger buffer of NaN, at an odd address and stride: a kernel that reads or writes outside shows.
class Padded {
 public:
  Padded(int rows, int cols, int padding = 3)
      : rows_(rows), cols_(cols), ld_(rows + padding), data_(static_cast<std::size_t>(ld_ * cols + 1), quiet_nan) {
    for (int c = 0; c < cols; ++c) {
      for (int r = 0; r < rows; ++r) view()(r, c) = 0.0;
    }
  }
  MatrixView view() { return {data_.data() + 1, rows_, cols_, ld_}; }
  double& operator()(int r, int c) { return view()(r, c); }
  bool padding_untouched() {
    if (!std::isnan(data_[0])) return false;
    for (int c = 0; c < cols_; ++c) {
      for (int r = rows_; r < ld_; ++r) {
        if (!std::isnan(view()(r, c))) return false;
      }
    }
    return true;
  }
  MatrixXd matrix() {
    MatrixXd m(rows_, cols_);
    for (int c = 0; c < cols_; ++c) {
      for (int r = 0; r < rows_; ++r) m(r, c) = (*this)(r, c);
    }
    return m;
  }
  bool equals(Padded& other) {
    for (int c = 0; c < cols_; ++c) {
      if (rows_ > 0 &&
          std::memcmp(view().col(c), other.view().col(c), sizeof(double) * static_cast<std::size_t>(rows_)) != 0)
        return false;
    }
    return true;
  }

 private:
  int rows_;
  int cols_;
  int ld_;
  std::vector<double> data_;
};

/// Symmetric positive definite, eigenvalues of at least `floor`, bitwise symmetric.
void fill_covariance(Padded& P, int n, Generator& generator, double floor = 1.0) {
  constexpr int rank = 9;
  std::vector<double> a(static_cast<std::size_t>(n * rank));
  for (double& x : a) x = draw(generator);
  for (int c = 0; c < n; ++c) {
    for (int r = c; r < n; ++r) {
      double sum = r == c ? floor : 0.0;
      for (int k = 0; k < rank; ++k)
        sum += a[static_cast<std::size_t>(r * rank + k)] * a[static_cast<std::size_t>(c * rank + k)];
      P(r, c) = sum;
      P(c, r) = sum;
    }
  }
}

void fill(Padded& M, int rows, int cols, Generator& generator) {
  for (int c = 0; c < cols; ++c) {
    for (int r = 0; r < rows; ++r) M(r, c) = draw(generator);
  }
}

/// Lower triangular with a positive diagonal; the strict upper triangle holds NaN, which nothing may read.
void fill_triangle(Padded& L, int m, Generator& generator) {
  for (int c = 0; c < m; ++c) {
    for (int r = 0; r < m; ++r)
      L(r, c) = r < c ? quiet_nan : r == c ? 1.0 + generator.uniform() : 0.3 * draw(generator);
  }
}

std::vector<SparseRowPair> make_rows(int n, int pairs, Generator& generator) {
  std::vector<SparseRowPair> rows(static_cast<std::size_t>(pairs));
  for (SparseRowPair& pair : rows) {
    const int room = n - motion_states;
    const bool six = generator.below(2) == 1;
    pair.feature_size = room >= 6 && six ? 6 : room >= 3 ? 3 : 0;
    pair.feature_offset =
        motion_states + static_cast<int>(generator.below(static_cast<std::uint32_t>(room - pair.feature_size) + 1U));
    for (int k = 0; k < 2; ++k) {
      for (int c = 0; c < 6; ++c) pair.motion[k][c] = draw(generator);
      for (int c = 0; c < pair.feature_size; ++c) pair.feature[k][c] = draw(generator);
    }
    if (generator.below(3) == 0) pair.motion[0][8] = draw(generator);  // a column where one of the two is zero
  }
  return rows;
}

MatrixXd dense(const std::vector<SparseRowPair>& rows, int n) {
  MatrixXd H = MatrixXd::Zero(2 * static_cast<int>(rows.size()), n);
  int i = 0;
  for (const SparseRowPair& pair : rows) {
    for (int k = 0; k < 2; ++k, ++i) {
      for (int c = 0; c < motion_states; ++c) H(i, c) = pair.motion[k][c];
      for (int c = 0; c < pair.feature_size; ++c) H(i, pair.feature_offset + c) = pair.feature[k][c];
    }
  }
  return H;
}

double difference(const MatrixXd& a, const MatrixXd& b) { return a.size() == 0 ? 0.0 : (a - b).cwiseAbs().maxCoeff(); }

MatrixXd lower_of(Padded& M, int m) {
  MatrixXd lower(m, m);
  for (int c = 0; c < m; ++c) {
    for (int r = 0; r < m; ++r) lower(r, c) = r < c ? 0.0 : M(r, c);
  }
  return lower;
}

std::string describe(int n, int m) {
  return "seed " + std::to_string(seed) + " n " + std::to_string(n) + " m " + std::to_string(m);
}

// The same sums in the same order, in the plainest form.
void plain_cholesky(MatrixView S) {
  for (int c = 0; c < S.cols; ++c) {
    for (int r = c; r < S.rows; ++r) {
      double sum = S(r, c);
      for (int k = 0; k < c; ++k) sum -= S(r, k) * S(c, k);
      S(r, c) = r == c ? std::sqrt(sum) : sum * (1.0 / S(c, c));
    }
  }
}
void plain_solve_right_transposed(ConstMatrixView L, MatrixView B) {
  for (int j = 0; j < B.cols; ++j) {
    for (int i = 0; i < B.rows; ++i) {
      double sum = B(i, j);
      for (int k = 0; k < j; ++k) sum -= B(i, k) * L(j, k);
      B(i, j) = sum * (1.0 / L(j, j));
    }
  }
}
void plain_downdate(MatrixView P, ConstMatrixView B) {
  for (int j = 0; j < P.cols; ++j) {
    for (int i = j; i < P.rows; ++i) {
      double sum = P(i, j);
      for (int k = 0; k < B.cols; ++k) sum -= B(i, k) * B(j, k);
      P(i, j) = sum;
      P(j, i) = sum;
    }
  }
}
void plain_multiply_p_ht(ConstMatrixView P, const std::vector<SparseRowPair>& rows, MatrixView PHt) {
  for (int i = 0; i < P.rows; ++i) {
    int column = 0;
    for (const SparseRowPair& pair : rows) {
      for (int k = 0; k < 2; ++k, ++column) {
        double sum = 0.0;
        for (int c = 0; c < motion_states; ++c) sum += P(i, c) * pair.motion[k][c];
        for (int c = 0; c < pair.feature_size; ++c) sum += P(i, pair.feature_offset + c) * pair.feature[k][c];
        PHt(i, column) = sum;
      }
    }
  }
}

constexpr int state_sizes[] = {12, 13, 14, 15, 18, 19, 27, 45, 66, 101, 252};
constexpr int row_counts[] = {0, 1, 2, 3, 4, 5, 6, 7, 9, 16, 31, 60};
constexpr int pair_counts[] = {0, 1, 2, 3, 5, 8, 30};

}  // namespace

TEST_GROUP(CovarianceKernels){};

TEST(CovarianceKernels, leading_dimension_is_padded_and_no_power_of_two) {
  LONGS_EQUAL(24, (MatrixStorage<12, 12>::leading_dimension));
  LONGS_EQUAL(24, (MatrixStorage<1, 1>::leading_dimension));
  LONGS_EQUAL(264, (MatrixStorage<252, 252>::leading_dimension));
  LONGS_EQUAL(72, (MatrixStorage<60, 60>::leading_dimension));
  LONGS_EQUAL(40, (MatrixStorage<33, 2>::leading_dimension));
  static MatrixStorage<13, 5> storage;
  const MatrixView view = storage.view(11, 4);
  LONGS_EQUAL(11, view.rows);
  LONGS_EQUAL(4, view.cols);
  LONGS_EQUAL(0, static_cast<long>(reinterpret_cast<std::uintptr_t>(view.col(3)) % 64));
}

TEST(CovarianceKernels, p_ht_and_s_agree_with_dense_products) {
  Generator generator(seed);
  for (const int n : state_sizes) {
    for (const int pairs : pair_counts) {
      const int m = 2 * pairs;
      Padded P(n, n);
      fill_covariance(P, n, generator);
      const auto rows = make_rows(n, pairs, generator);
      std::vector<double> r(static_cast<std::size_t>(m));
      for (double& x : r) x = 0.1 + generator.uniform();
      Padded PHt(n, m, 1);
      Padded reference(n, m);
      Padded S(m, m, 2);
      for (int c = 0; c < m; ++c) {
        for (int i = 0; i < c; ++i) S(i, c) = quiet_nan;
      }
      multiply_p_ht(P.view(), rows, PHt.view());
      innovation_covariance(rows, PHt.view(), r, S.view());
      plain_multiply_p_ht(P.view(), rows, reference.view());
      CHECK_TEXT(PHt.equals(reference), describe(n, m).c_str());
      CHECK_TEXT(PHt.padding_untouched() && S.padding_untouched(), describe(n, m).c_str());
      const MatrixXd H = dense(rows, n);
      const MatrixXd expected = product(P.matrix(), H.transpose());
      CHECK_TEXT(difference(PHt.matrix(), expected) < 1e-12, describe(n, m).c_str());
      const MatrixXd expected_S = product(H, expected);
      for (int c = 0; c < m; ++c) {
        for (int i = 0; i < m; ++i) {
          if (i < c) {
            CHECK_TEXT(std::isnan(S(i, c)), describe(n, m).c_str());
          } else {
            const double want = expected_S(i, c) + (i == c ? r[static_cast<std::size_t>(i)] : 0.0);
            CHECK_TEXT(std::abs(S(i, c) - want) < 1e-12, describe(n, m).c_str());
          }
        }
      }
    }
  }
}

TEST(CovarianceKernels, nan_in_a_row_of_h_is_not_skipped) {
  Generator generator(seed);
  Padded P(15, 15);
  fill_covariance(P, 15, generator);
  auto rows = make_rows(15, 1, generator);
  rows[0].motion[1][11] = quiet_nan;
  Padded PHt(15, 2);
  multiply_p_ht(P.view(), rows, PHt.view());
  CHECK(!std::isnan(PHt(14, 0)));
  CHECK(std::isnan(PHt(14, 1)));
}

TEST(CovarianceKernels, cholesky_gives_back_the_matrix_and_is_bitwise_the_plain_loop) {
  Generator generator(seed);
  for (const int m : row_counts) {
    Padded S(m, m);
    Padded reference(m, m, 6);
    fill_covariance(S, m, generator);
    const MatrixXd before = S.matrix();
    for (int c = 0; c < m; ++c) {
      for (int r = 0; r < m; ++r) {
        if (r < c) S(r, c) = quiet_nan;
        reference(r, c) = S(r, c);
      }
    }
    CHECK_TEXT(cholesky_lower(S.view()) == Status::ok, describe(0, m).c_str());
    plain_cholesky(reference.view());
    for (int c = 0; c < m; ++c) {
      for (int r = 0; r < m; ++r)
        CHECK_TEXT(r < c ? std::isnan(S(r, c)) : test::same_bits(S(r, c), reference(r, c)), describe(0, m).c_str());
    }
    CHECK(S.padding_untouched());
    if (m > 0) {
      const MatrixXd L = lower_of(S, m);
      CHECK_TEXT(difference(product(L, L.transpose()), before) < 1e-12, describe(0, m).c_str());
    }
  }
}

TEST(CovarianceKernels, cholesky_refuses_pivots_that_are_not_positive) {
  const double bad[] = {
      0.0, -0.0, -1.0, quiet_nan, std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  for (const int m : {1, 2, 4, 5, 60}) {
    for (int at = 0; at < m; ++at) {
      for (const double value : bad) {
        Padded S(m, m);
        for (int i = 0; i < m; ++i) S(i, i) = 1.0;
        S(at, at) = value;
        CHECK(cholesky_lower(S.view()) == Status::not_positive_definite);
      }
    }
  }
  // A NaN below the diagonal reaches a pivot, an indefinite matrix with a positive diagonal fails at its second.
  Padded S(5, 5);
  for (int i = 0; i < 5; ++i) S(i, i) = 1.0;
  S(4, 0) = quiet_nan;
  CHECK(cholesky_lower(S.view()) == Status::not_positive_definite);
  Padded T(2, 2);
  T(0, 0) = T(1, 1) = 1.0;
  T(1, 0) = 2.0;
  CHECK(cholesky_lower(T.view()) == Status::not_positive_definite);
}

TEST(CovarianceKernels, triangular_solve_agrees_with_the_dense_product_and_bitwise_with_the_plain_loop) {
  Generator generator(seed);
  for (const int n : state_sizes) {
    for (const int m : row_counts) {
      Padded L(m, m, 1);
      Padded B(n, m);
      Padded reference(n, m, 5);
      fill_triangle(L, m, generator);
      fill(B, n, m, generator);
      const MatrixXd before = B.matrix();
      for (int c = 0; c < m; ++c) {
        for (int r = 0; r < n; ++r) reference(r, c) = B(r, c);
      }
      solve_right_transposed(L.view(), B.view());
      plain_solve_right_transposed(L.view(), reference.view());
      CHECK_TEXT(B.equals(reference), describe(n, m).c_str());
      CHECK_TEXT(B.padding_untouched(), describe(n, m).c_str());
      const MatrixXd again = product(B.matrix(), lower_of(L, m).transpose());
      const double scale = m == 0 ? 1.0 : std::max(1.0, B.matrix().cwiseAbs().maxCoeff());
      CHECK_TEXT(difference(again, before) < 1e-12 * scale, describe(n, m).c_str());
    }
  }
}

TEST(CovarianceKernels, vector_solve_and_state_increment) {
  Generator generator(seed);
  for (const int m : row_counts) {
    constexpr int n = 27;
    Padded L(m, m);
    Padded B(n, m);
    fill_triangle(L, m, generator);
    fill(B, n, m, generator);
    Eigen::VectorXd y(m);
    for (int i = 0; i < m; ++i) y(i) = draw(generator);
    Eigen::VectorXd solved = y;
    const std::span<double> x(solved.data(), static_cast<std::size_t>(m));
    solve_lower(L.view(), x);
    const double largest = solved.size() == 0 ? 0.0 : solved.cwiseAbs().maxCoeff();
    CHECK_TEXT(difference(product(lower_of(L, m), solved), y) < 1e-12 * std::max(1.0, largest), describe(n, m).c_str());
    Eigen::VectorXd dx = Eigen::VectorXd::Constant(n, quiet_nan);
    state_increment(B.view(), x, std::span<double>(dx.data(), n));
    CHECK_TEXT(difference(dx, product(B.matrix(), solved)) < 1e-10 * std::max(1.0, dx.cwiseAbs().maxCoeff()),
               describe(n, m).c_str());
  }
}

TEST(CovarianceKernels, downdate_agrees_with_the_dense_product_and_bitwise_with_the_plain_loop) {
  Generator generator(seed);
  for (int n = 0; n <= 40; ++n) {
    for (const int m : row_counts) {
      Padded P(n, n);
      Padded reference(n, n, 8);
      Padded B(n, m, 1);
      fill_covariance(P, n, generator);
      fill(B, n, m, generator);
      for (int c = 0; c < n; ++c) {
        for (int r = 0; r < n; ++r) reference(r, c) = P(r, c);
      }
      const MatrixXd expected = P.matrix() - product(B.matrix(), B.matrix().transpose());
      downdate_symmetric(P.view(), B.view());
      plain_downdate(reference.view(), B.view());
      CHECK_TEXT(P.equals(reference), describe(n, m).c_str());
      CHECK_TEXT(P.padding_untouched(), describe(n, m).c_str());
      CHECK_TEXT(difference(P.matrix(), expected) < 1e-12, describe(n, m).c_str());
    }
  }
}

TEST(CovarianceKernels, mirror_copies_the_lower_triangle) {
  for (int n = 0; n <= 40; ++n) {
    Padded P(n, n);
    for (int c = 0; c < n; ++c) {
      for (int r = 0; r < n; ++r) P(r, c) = r < c ? quiet_nan : 100.0 * r + c;
    }
    mirror_lower(P.view());
    for (int c = 0; c < n; ++c) {
      for (int r = 0; r < n; ++r) DOUBLES_EQUAL(100.0 * std::max(r, c) + std::min(r, c), P(r, c), 0.0);
    }
    CHECK(P.padding_untouched());
  }
}

TEST(CovarianceKernels, whole_update_agrees_with_the_textbook_and_stays_positive_definite) {
  Generator generator(seed);
  for (const int n : state_sizes) {
    for (const int pairs : pair_counts) {
      const int m = 2 * pairs;
      Padded P(n, n);
      fill_covariance(P, n, generator, 1e-3);
      const auto rows = make_rows(n, pairs, generator);
      const std::vector<double> r(static_cast<std::size_t>(m), 1e-4);
      const MatrixXd before = P.matrix();
      Padded B(n, m);
      Padded S(m, m);
      multiply_p_ht(P.view(), rows, B.view());
      innovation_covariance(rows, B.view(), r, S.view());
      CHECK_TEXT(cholesky_lower(S.view()) == Status::ok, describe(n, m).c_str());
      solve_right_transposed(S.view(), B.view());
      downdate_symmetric(P.view(), B.view());
      const MatrixXd H = dense(rows, n);
      MatrixXd expected = before;
      if (m > 0) {
        const MatrixXd HP = product(H, before);
        MatrixXd full_S = product(HP, H.transpose());
        for (int i = 0; i < m; ++i) full_S(i, i) += 1e-4;
        expected -= product(HP.transpose(), test::solve_symmetric(full_S, HP));
      }
      CHECK_TEXT(difference(P.matrix(), expected) < 1e-9, describe(n, m).c_str());
      CHECK_TEXT(difference(P.matrix(), P.matrix().transpose()) <= 0.0, describe(n, m).c_str());
      if (n <= 101) {
        Padded L(n, n);
        for (int c = 0; c < n; ++c) {
          for (int i = 0; i < n; ++i) L(i, c) = P(i, c);
        }
        plain_cholesky(L.view());
        for (int i = 0; i < n; ++i) CHECK_TEXT(L(i, i) > 0.0, describe(n, m).c_str());  // a NaN is not
      }
    }
  }
}

TEST(CovarianceKernels, positive_definite_after_many_predictions_and_updates) {
  Generator generator(seed);
  constexpr int n = 48;
  constexpr int pairs = 6;
  Padded P(n, n);
  fill_covariance(P, n, generator);
  Mat<12, 12> F = Mat<12, 12>::Identity();
  for (int i = 0; i < 6; ++i) F(i, i + 6) = 0.1;
  Mat<12, 12> Q = Mat<12, 12>::Identity() * 1e-6;
  const std::vector<double> r(2 * pairs, 1e-6);
  Padded B(n, 2 * pairs);
  Padded S(2 * pairs, 2 * pairs);
  for (int step = 0; step < 400; ++step) {
    predict_motion(P.view(), F, Q);
    const auto rows = make_rows(n, pairs, generator);
    multiply_p_ht(P.view(), rows, B.view());
    innovation_covariance(rows, B.view(), r, S.view());
    CHECK_TEXT(cholesky_lower(S.view()) == Status::ok, describe(n, step).c_str());
    solve_right_transposed(S.view(), B.view());
    downdate_symmetric(P.view(), B.view());
  }
  CHECK(cholesky_lower(P.view()) == Status::ok);
}

TEST(CovarianceKernels, prediction_agrees_with_the_dense_product) {
  Generator generator(seed);
  for (const int n : state_sizes) {
    Padded P(n, n);
    fill_covariance(P, n, generator);
    const MatrixXd before = P.matrix();
    Mat<12, 12> F;
    Mat<12, 12> G;
    for (int c = 0; c < 12; ++c) {
      for (int i = 0; i < 12; ++i) {
        F(i, c) = draw(generator);
        G(i, c) = draw(generator);
      }
    }
    const Mat<12, 12> Q = product(G, G.transpose());
    predict_motion(P.view(), F, Q);
    MatrixXd full = MatrixXd::Identity(n, n);
    full.topLeftCorner(12, 12) = F;
    MatrixXd expected = test::congruence(full, before);
    expected.topLeftCorner(12, 12) += Q;
    CHECK_TEXT(difference(P.matrix(), expected) < 1e-11, describe(n, 0).c_str());
    CHECK_TEXT(difference(P.matrix(), P.matrix().transpose()) <= 0.0, describe(n, 0).c_str());
    const MatrixXd rest = P.matrix().bottomRightCorner(n - 12, n - 12);
    CHECK_TEXT(difference(rest, before.bottomRightCorner(n - 12, n - 12)) <= 0.0, describe(n, 0).c_str());
    CHECK(P.padding_untouched());
  }
}

TEST(CovarianceKernels, block_transformation_agrees_with_the_dense_congruence) {
  Generator generator(seed);
  for (const int n : state_sizes) {
    for (int offset = 0; offset + 3 <= n; offset += n > 200 ? 83 : n > 30 ? 13 : 1) {
      Padded P(n, n);
      fill_covariance(P, n, generator);
      const MatrixXd before = P.matrix();
      Mat3 J;
      for (int c = 0; c < 3; ++c) {
        for (int i = 0; i < 3; ++i) J(i, c) = draw(generator);
      }
      transform_block(P.view(), offset, J);
      MatrixXd full = MatrixXd::Identity(n, n);
      full.block(offset, offset, 3, 3) = J;
      const MatrixXd expected = test::congruence(full, before);
      CHECK_TEXT(difference(P.matrix(), expected) < 1e-12, describe(n, offset).c_str());
      CHECK_TEXT(difference(P.matrix(), P.matrix().transpose()) <= 0.0, describe(n, offset).c_str());
      CHECK(P.padding_untouched());
    }
  }
}

// The whole chain must give these bits on every target, compiler, optimisation level and vector width.
TEST(CovarianceKernels, golden_bits) {
  Generator generator(seed);
  constexpr int n = 63;
  Padded P(n, n);
  fill_covariance(P, n, generator);
  Mat<12, 12> F = Mat<12, 12>::Identity();
  Mat<12, 12> Q = Mat<12, 12>::Zero();
  for (int i = 0; i < 6; ++i) {
    F(i, i + 6) = 0.1;
    Q(i, i) = 1e-3;
  }
  for (int step = 0; step < 10; ++step) {
    predict_motion(P.view(), F, Q);
    const int pairs = 1 + step;
    const auto rows = make_rows(n, pairs, generator);
    const std::vector<double> r(static_cast<std::size_t>(2 * pairs), 1e-3);
    Padded B(n, 2 * pairs);
    Padded S(2 * pairs, 2 * pairs);
    multiply_p_ht(P.view(), rows, B.view());
    innovation_covariance(rows, B.view(), r, S.view());
    CHECK(cholesky_lower(S.view()) == Status::ok);
    solve_right_transposed(S.view(), B.view());
    downdate_symmetric(P.view(), B.view());
    Mat3 J = Mat3::Identity() * -0.5;
    J(0, 1) = 0.25;
    transform_block(P.view(), 3 * step, J);
  }
  test::BitHash hash;
  for (int c = 0; c < n; ++c) {
    for (int r = 0; r < n; ++r) hash.add(P(r, c));
  }
  char text[32];
  std::snprintf(text, sizeof(text), "%016llx", static_cast<unsigned long long>(hash.value()));
  STRCMP_EQUAL("0e29588484445eaf", text);
}
