// Fixed in small Eigen matrices: products, norms and factorisations against the same in double; soundness of a matrix.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "fsw/base/generator.hpp"
#include "fsw/math/scalar.hpp"
#include "tests/support/dense.hpp"

#include <CppUTest/TestHarness.h>

using namespace relnav;

namespace {

constexpr std::uint64_t seed = 271828;

/// Elements within a third.
template <typename S, int Rows, int Cols>
Eigen::Matrix<S, Rows, Cols> random_matrix(Generator& generator) {
  Eigen::Matrix<S, Rows, Cols> m;
  for (int r = 0; r < Rows; ++r) {
    for (int c = 0; c < Cols; ++c) m(r, c) = S((2.0 * generator.uniform() - 1.0) / 3.0);
  }
  return m;
}

template <typename S, int Rows, int Cols>
Eigen::MatrixXd in_double(const Eigen::Matrix<S, Rows, Cols>& m) {
  Eigen::MatrixXd out(Rows, Cols);
  for (int r = 0; r < Rows; ++r) {
    for (int c = 0; c < Cols; ++c) out(r, c) = static_cast<double>(m(r, c));
  }
  return out;
}

double largest_difference(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) { return (a - b).cwiseAbs().maxCoeff(); }

/// Largest difference of anything from double.
template <typename S>
double worst_of(int count) {
  using Matrix = Eigen::Matrix<S, 3, 3>;
  using Vector = Eigen::Matrix<S, 3, 1>;
  Generator generator(seed);
  double worst = 0.0;
  const auto compare = [&](const auto& actual, const Eigen::MatrixXd& expected) {
    CHECK(is_sound(actual));
    worst = std::max(worst, largest_difference(in_double(actual), expected));
  };
  for (int i = 0; i < count; ++i) {
    const Matrix A = random_matrix<S, 3, 3>(generator);
    const Vector b = random_matrix<S, 3, 1>(generator);
    const Eigen::MatrixXd A_d = in_double(A);
    const Eigen::MatrixXd b_d = in_double(b);
    compare(Matrix(A * A.transpose()), test::product(A_d, A_d.transpose()));
    compare(Vector(A * b - b), test::product(A_d, b_d) - b_d);
    const S norm = b.norm();
    worst = std::max(worst, std::fabs(static_cast<double>(norm) - b_d.norm()));
    // Eigenvalues from 1 to 2, so that no solution leaves the range.
    const Matrix P = A * A.transpose() + Matrix::Identity();
    const Eigen::MatrixXd P_d = in_double(P);
    compare(Vector(P.llt().solve(b)), test::solve_symmetric(P_d, b_d));
    compare(Matrix(P.inverse()), test::solve_symmetric(P_d, Eigen::MatrixXd::Identity(3, 3)));
  }
  return worst;
}

}  // namespace

TEST_GROUP(FixedEigen){};

TEST(FixedEigen, products_norms_and_factorisations_agree_with_double) {
  const double q47 = worst_of<FixedQ47>(500);
  const double q56 = worst_of<FixedQ56>(500);
  const double q29 = worst_of<FixedQ29>(500);
  std::printf("    off by: Q16.47 %.1e, Q7.56 %.1e, Q2.29 %.1e\n", q47, q56, q29);
  CHECK(q47 < 10 * 0x1p-47);
  CHECK(q56 < 3e-15);  // what double leaves
  CHECK(q29 < 10 * 0x1p-29);
  CHECK(q29 > 0x1p-31);
}

TEST(FixedEigen, one_overflow_makes_a_matrix_unsound) {
  Eigen::Matrix<FixedQ29, 3, 3> A = Eigen::Matrix<FixedQ29, 3, 3>::Identity();
  CHECK(is_sound(A));
  CHECK(is_sound((A + A + A).eval()));
  CHECK_FALSE(is_sound((A + A + A + A).eval()));
  A(2, 1) = FixedQ29(1) / FixedQ29(0);
  CHECK_FALSE(is_sound(A));
  CHECK_FALSE(is_sound((A * A).eval()));
  Eigen::Matrix<double, 2, 2> B = Eigen::Matrix<double, 2, 2>::Zero();
  CHECK(is_sound(B));
  B(1, 0) = 0.0 / B(0, 0);
  CHECK_FALSE(is_sound(B));
}

TEST(FixedEigen, limits_are_those_of_the_format) {
  using Limits = Eigen::NumTraits<FixedQ29>;
  CHECK(Limits::highest().raw() == INT32_MAX);
  CHECK(Limits::lowest().raw() == -INT32_MAX);
  CHECK(is_sound(Limits::highest()) && is_sound(Limits::lowest()));
  CHECK((Limits::highest() + Limits::epsilon()).overflowed());
  CHECK((Limits::lowest() - Limits::epsilon()).overflowed());
  // What Eigen takes for nothing: some steps, as rounding leaves them.
  CHECK(Limits::dummy_precision() > Limits::epsilon());
  CHECK(Limits::dummy_precision() < FixedQ29(1e-6));
}
