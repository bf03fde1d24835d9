// symmetric_eigen against Eigen's solver and by its own definition.
#include "fsw/math/symmetric_eigen.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <type_traits>

#include "fsw/base/generator.hpp"
#include "fsw/math/fixed.hpp"
#include "tests/support/dense.hpp"

#include <CppUTest/TestHarness.h>

namespace relnav {
namespace {

constexpr std::uint64_t seed = 577215;

template <int N>
using Matrix = Eigen::Matrix<double, N, N>;

template <int N>
Matrix<N> random_matrix(Generator& generator) {
  Matrix<N> m;
  for (int r = 0; r < N; ++r) {
    for (int c = 0; c < N; ++c) m(r, c) = 2.0 * generator.uniform() - 1.0;
  }
  return m;
}

struct Errors {
  double values = 0.0;   ///< against Eigen, over the largest (fixed point: or over 1)
  double product = 0.0;  ///< A V - V D, over the largest
  double unit = 0.0;     ///< V'V - I
  bool flagged = false;  ///< fixed point left its range
  void add(const Errors& e) {
    values = std::max(values, e.values);
    product = std::max(product, e.product);
    unit = std::max(unit, e.unit);
    flagged = flagged || e.flagged;
  }
};

bool is_flagged(double x) { return !std::isfinite(x); }
bool is_flagged(float x) { return !std::isfinite(x); }
bool is_flagged(FixedQ47 x) { return x.overflowed(); }

template <typename S, int N>
Errors errors_for(const Matrix<N>& A) {
  Eigen::Matrix<S, N, N> D;
  Eigen::Matrix<S, N, N> V;
  Matrix<N> stored;
  for (int r = 0; r < N; ++r) {
    for (int c = 0; c < N; ++c) {
      D(r, c) = S(A(r, c));
      stored(r, c) = static_cast<double>(D(r, c));
    }
  }
  symmetric_eigen<S, N>(D, V);
  Errors e;
  Matrix<N> v;
  Eigen::Matrix<double, N, 1> d;
  for (int r = 0; r < N; ++r) {
    for (int c = 0; c < N; ++c) {
      v(r, c) = static_cast<double>(V(r, c));
      e.flagged = e.flagged || is_flagged(V(r, c)) || is_flagged(D(r, c));
    }
    d(r) = static_cast<double>(D(r, r));
  }
  const Eigen::VectorXd reference = test::eigenvalues_of(stored);
  // Fixed point rounds by as much whatever the size.
  const double least_size = std::is_same_v<S, FixedQ47> ? 1.0 : 1e-300;
  const double size = std::max(reference.cwiseAbs().maxCoeff(), least_size);
  e.product = (stored * v - v * d.asDiagonal()).cwiseAbs().maxCoeff() / size;
  e.unit = (v.transpose() * v - Matrix<N>::Identity()).cwiseAbs().maxCoeff();
  std::sort(d.data(), d.data() + N);
  e.values = (d - reference).cwiseAbs().maxCoeff() / size;
  return e;
}

void check(const char* name, const Errors& e, double bound) {
  std::printf("    %s: values %.1e, A V - V D %.1e, V'V - I %.1e\n", name, e.values, e.product, e.unit);
  CHECK_FALSE(e.flagged);
  CHECK(e.values < bound);
  CHECK(e.product < bound);
  CHECK(e.unit < bound);
}

template <typename S, int N>
Errors over_random(int count, double smallest) {
  Generator generator(seed);
  Errors worst;
  for (int i = 0; i < count; ++i) {
    // Eigenvalues of both signs, spread over decades down to `smallest`, some of them equal.
    const Matrix<N> Q = test::orthogonal_of(random_matrix<N>(generator));
    Eigen::Matrix<double, N, 1> d;
    for (int k = 0; k < N; ++k) {
      d(k) = (generator.below(2) == 0 ? 1.0 : -1.0) * std::pow(smallest, generator.uniform());
      if (k > 0 && generator.below(4) == 0) d(k) = d(k - 1);
    }
    Matrix<N> A = Q * d.asDiagonal() * Q.transpose();
    A = (0.5 * (A + A.transpose())).eval();
    worst.add(errors_for<S, N>(A));
  }
  return worst;
}

}  // namespace

TEST_GROUP(SymmetricEigen){};

TEST(SymmetricEigen, agrees_with_eigen) {
  check("double, 3", over_random<double, 3>(3000, 0.1), 1e-14);
  check("double, 4", over_random<double, 4>(3000, 0.1), 1e-14);
  check("double, 6, ill conditioned", over_random<double, 6>(1000, 1e-14), 1e-14);
  check("float, 4", over_random<float, 4>(2000, 0.01), 4e-6);
  check("fixed, 3", over_random<FixedQ47, 3>(500, 0.1), 1e-12);
  check("fixed, 4, ill conditioned", over_random<FixedQ47, 4>(500, 1e-9), 1e-12);
}

TEST(SymmetricEigen, diagonal_equal_and_zero_matrices) {
  check("zero", errors_for<double, 3>(Matrix<3>::Zero()), 1e-300);
  check("identity", errors_for<double, 4>(Matrix<4>::Identity()), 1e-300);
  check("all ones", errors_for<double, 4>(Matrix<4>::Ones()), 1e-15);
  check("fixed, all ones", errors_for<FixedQ47, 4>(Matrix<4>::Ones()), 3e-13);
  check("fixed, zero", errors_for<FixedQ47, 4>(Matrix<4>::Zero()), 1e-300);
}

TEST(SymmetricEigen, small_elements_beside_equal_diagonal_ones) {
  for (double off = 0.1; off > 1e-14; off *= 0.5) {
    Matrix<3> A = Matrix<3>::Identity();
    A(0, 1) = A(1, 0) = off;
    A(1, 2) = A(2, 1) = -off;
    const Errors e = errors_for<FixedQ47, 3>(A);
    CHECK_FALSE(e.flagged);
    CHECK(e.values < 3e-13);
    CHECK(e.product < 3e-13);
    CHECK(e.unit < 3e-13);
  }
}

TEST(SymmetricEigen, any_size_that_a_double_holds) {
  Generator generator(seed + 1);
  for (const double size : {1e-300, 1e-200, 1e-100, 1e100, 1e200, 1e300}) {
    const Matrix<3> m = random_matrix<3>(generator);
    const Errors e = errors_for<double, 3>(size * (m + m.transpose()));
    CHECK_FALSE(e.flagged);
    CHECK(e.values < 1e-14);
    CHECK(e.unit < 1e-14);
  }
}

}  // namespace relnav
