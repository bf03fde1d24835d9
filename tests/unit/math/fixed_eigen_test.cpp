// Fixed in small Eigen matrices: products, norms and factorisations against the same in double; soundness of a matrix.
#include <cstdio>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "fsw/base/generator.hpp"
#include "fsw/math/scalar.hpp"

#include <CppUTest/TestHarness.h>

using namespace relnav;

namespace {

constexpr std::uint64_t seed = 271828;

template <int Rows, int Cols>
Eigen::Matrix<double, Rows, Cols> random_matrix(Generator& generator) {
  Eigen::Matrix<double, Rows, Cols> m;
  for (int r = 0; r < Rows; ++r) {
    for (int c = 0; c < Cols; ++c) m(r, c) = 2.0 * generator.uniform() - 1.0;
  }
  return m;
}

/// Largest difference of anything from double.
template <typename S>
double worst_of(int count) {
  Generator generator(seed);
  double worst = 0.0;
  const auto compare = [&](const auto& actual, const auto& expected) {
    CHECK(is_sound(actual.eval()));
    worst = std::max(worst, (actual.template cast<double>() - expected).cwiseAbs().maxCoeff());
  };
  for (int i = 0; i < count; ++i) {
    const Eigen::Matrix<S, 3, 3> A = (random_matrix<3, 3>(generator) / 3.0).template cast<S>();
    const Eigen::Matrix<S, 3, 1> b = (random_matrix<3, 1>(generator) / 3.0).template cast<S>();
    const Eigen::Matrix<double, 3, 3> A_d = A.template cast<double>();
    const Eigen::Matrix<double, 3, 1> b_d = b.template cast<double>();
    compare(A * A.transpose(), A_d * A_d.transpose());
    compare(A * b - b, A_d * b_d - b_d);
    const S norm = b.norm();
    worst = std::max(worst, std::fabs(static_cast<double>(norm) - b_d.norm()));
    // Eigenvalues from 1 to 2, so that no solution leaves the range.
    const Eigen::Matrix<S, 3, 3> P = A * A.transpose() + Eigen::Matrix<S, 3, 3>::Identity();
    const Eigen::Matrix<double, 3, 3> P_d = P.template cast<double>();
    const Eigen::Matrix<S, 3, 1> x = P.llt().solve(b);
    compare(x, P_d.llt().solve(b_d).eval());
    compare(P.inverse().eval(), P.template cast<double>().inverse().eval());
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
