// NormalEquations against dense solutions in double.
#include "fsw/math/normal_equations.hpp"

#include <cmath>
#include <cstdio>
#include <limits>

#include "fsw/base/generator.hpp"
#include "fsw/math/fixed.hpp"
#include "fsw/math/types.hpp"
#include "tests/support/dense.hpp"

#include <CppUTest/TestHarness.h>

namespace relnav {
namespace {

constexpr std::uint64_t seed = 271828;
constexpr int rows = 16;

struct Problem {
  Eigen::MatrixXd J;  // of rows x N
  Eigen::VectorXd r;
};

/// Columns scaled by 1 .. 1 / spread, the last one nearly a combination of the others by `dependence` (1: independent).
Problem random_problem(int N, Generator& generator, double spread, double dependence) {
  Problem p{Eigen::MatrixXd(rows, N), Eigen::VectorXd(rows)};
  const auto unit = [&] { return 2.0 * generator.uniform() - 1.0; };
  for (int i = 0; i < rows; ++i) {
    for (int k = 0; k < N; ++k) p.J(i, k) = unit();
    p.r(i) = unit();
  }
  for (int i = 0; i < rows; ++i) {
    double others = 0.0;
    for (int k = 0; k < N - 1; ++k) others += p.J(i, k);
    p.J(i, N - 1) = dependence * p.J(i, N - 1) + (1.0 - dependence) * others;
  }
  for (int k = 0; k < N; ++k) p.J.col(k) *= std::pow(spread, -static_cast<double>(k) / (N - 1));
  return p;
}

template <typename S, int N>
NormalEquations<S, N> equations_of(const Problem& p) {
  NormalEquations<S, N> e;
  e.clear();
  for (int i = 0; i < rows; ++i) {
    std::array<S, static_cast<std::size_t>(N)> j;
    for (int k = 0; k < N; ++k) j[static_cast<std::size_t>(k)] = S(p.J(i, k));
    e.add(j, S(p.r(i)));
  }
  return e;
}

struct Errors {
  double solution = 0.0;  ///< relative to the norm, over the condition number of the column-scaled matrix
  double inverse = 0.0;
  double gain = 0.0;
  double cost = 0.0;
};

/// The solution for the matrix scaled to unit diagonal, with whose condition error bounds of the factorisation go (van der
/// Sluis).
struct DenseSolution {
  explicit DenseSolution(const Problem& p) {
    const Eigen::Index N = p.J.cols();
    const Eigen::MatrixXd A = test::product(p.J.transpose(), p.J);
    const Eigen::VectorXd b = test::product(p.J.transpose(), p.r);
    Eigen::MatrixXd scaled(N, N);
    Eigen::VectorXd scaled_b(N);
    scale.resize(N);
    for (Eigen::Index k = 0; k < N; ++k) scale(k) = 1.0 / std::sqrt(A(k, k));
    for (Eigen::Index c = 0; c < N; ++c) {
      for (Eigen::Index r = 0; r < N; ++r) scaled(r, c) = scale(r) * A(r, c) * scale(c);
      scaled_b(c) = scale(c) * b(c);
    }
    const Eigen::VectorXd eigenvalues = test::eigenvalues_of(scaled);
    condition = eigenvalues(N - 1) / eigenvalues(0);
    z = test::solve_symmetric(scaled, scaled_b);
    Q = test::solve_symmetric(scaled, Eigen::MatrixXd::Identity(N, N));
    z_size = z.norm() + test::solve_symmetric(scaled, Eigen::VectorXd::Ones(N)).norm() / condition;
    gain = z.dot(scaled_b);
  }
  Eigen::VectorXd scale;
  Eigen::VectorXd z;
  Eigen::MatrixXd Q;
  double condition = 0.0;
  double z_size = 0.0;
  double gain = 0.0;
};

template <typename S, int N>
Errors largest_errors(double spread, double dependence) {
  Generator generator(seed);
  Errors out;
  for (int trial = 0; trial < 400; ++trial) {
    const Problem p = random_problem(N, generator, spread, dependence);
    NormalEquations<S, N> e = equations_of<S, N>(p);
    CHECK(e.factorise(S(0)) == Status::ok);
    S gain;
    const auto d = e.solution(gain);
    const auto P = e.inverse();

    const DenseSolution expected(p);
    double d_error = 0.0;
    double P_error = 0.0;
    for (int r = 0; r < N; ++r) {
      d_error = std::max(d_error, std::fabs(static_cast<double>(d(r)) / expected.scale(r) - expected.z(r)));
      for (int c = 0; c < N; ++c) {
        const double scaled = static_cast<double>(P(r, c)) / (expected.scale(r) * expected.scale(c));
        P_error = std::max(P_error, std::fabs(scaled - expected.Q(r, c)));
        CHECK(P(r, c) == P(c, r));
      }
    }
    const double condition = expected.condition;
    out.solution = std::max(out.solution, d_error / expected.z_size / condition);
    out.inverse = std::max(out.inverse, P_error / expected.Q.norm() / condition);
    out.gain = std::max(out.gain, std::fabs(static_cast<double>(gain) - expected.gain) / condition);
    out.cost = std::max(out.cost, std::fabs(static_cast<double>(e.cost()) - p.r.squaredNorm()));
  }
  return out;
}

void check(const char* name, const Errors& e, double bound) {
  std::printf("    %s: errors over condition: solution %.1e, inverse %.1e, gain %.1e; cost %.1e\n", name, e.solution,
              e.inverse, e.gain, e.cost);
  CHECK(e.solution < bound);
  CHECK(e.inverse < bound);
  CHECK(e.gain < bound);
  CHECK(e.cost < 16 * bound);
}

}  // namespace

TEST_GROUP(SmallNormalEquations){};

TEST(SmallNormalEquations, agree_with_a_dense_solution_in_double) {
  check("well conditioned", largest_errors<double, 6>(1.0, 1.0), 2e-15);
  check("three unknowns", largest_errors<double, 3>(1.0, 1.0), 2e-15);
  check("columns of very different size", largest_errors<double, 6>(1e6, 1.0), 2e-15);
  check("nearly dependent columns", largest_errors<double, 6>(1.0, 1e-4), 2e-15);
}

TEST(SmallNormalEquations, agree_with_a_dense_solution_in_float_and_fixed) {
  check("float", largest_errors<float, 6>(1.0, 1.0), 1e-6);
  check("float, columns of very different size", largest_errors<float, 6>(1e4, 1.0), 1e-6);
  check("fixed", largest_errors<FixedQ47, 6>(1.0, 1.0), 5e-14);
  check("fixed, nearly dependent columns", largest_errors<FixedQ47, 6>(1.0, 0.05), 5e-14);
}

TEST(SmallNormalEquations, rows_two_by_two_are_the_same_equations) {
  Generator generator(seed + 2);
  for (int trial = 0; trial < 400; ++trial) {
    const Problem p = random_problem(6, generator, 1.0, 1.0);
    NormalEquations<double, 6> one = equations_of<double, 6>(p);
    NormalEquations<double, 6, Pair<double>> two;
    two.clear();
    for (int i = 0; i < rows; i += 2) {
      std::array<Pair<double>, 6> j;
      for (int k = 0; k < 6; ++k) j[static_cast<std::size_t>(k)] = {p.J(i, k), p.J(i + 1, k)};
      two.add(j, {p.r(i), p.r(i + 1)});
    }
    CHECK(one.factorise(0.0) == Status::ok);
    CHECK(two.factorise(0.0) == Status::ok);
    double gain_one = 0.0;
    double gain_two = 0.0;
    const Vec6 d = one.solution(gain_one);
    CHECK((two.solution(gain_two) - d).norm() < 1e-10 * d.norm());
    DOUBLES_EQUAL(gain_one, gain_two, 1e-10 * gain_one);
    DOUBLES_EQUAL(one.cost(), two.cost(), 1e-13);
    CHECK((one.inverse() - two.inverse()).norm() < 1e-10 * one.inverse().norm());
  }
}

TEST(SmallNormalEquations, curvature_is_added_and_where_it_is_negative_the_step_still_leads_down) {
  Generator generator(seed + 3);
  int bent = 0;
  for (int trial = 0; trial < 400; ++trial) {
    const Problem p = random_problem(6, generator, 1.0, 1.0);
    NormalEquations<double, 6> e = equations_of<double, 6>(p);
    Mat6 K;
    for (int a = 0; a < 6; ++a) {
      for (int b = 0; b <= a; ++b) K(a, b) = K(b, a) = 2.0 * (2.0 * generator.uniform() - 1.0);
    }
    const Mat6 JtJ = test::product(p.J.transpose(), p.J);
    const Mat6 H = JtJ + K;
    const Vec6 b = test::product(p.J.transpose(), p.r);
    const bool expected = test::eigenvalues_of(H)(0) > 0.0;
    bool convex = !expected;
    CHECK(e.factorise(K, 0.0, 0.0, convex) == Status::ok);
    CHECK(convex == expected);
    double gain = 0.0;
    const Vec6 d = e.solution(gain);
    CHECK(gain > 0.0);
    DOUBLES_EQUAL(d.dot(b), gain, 1e-9 * gain);
    if (convex) {
      CHECK((H * d - b).norm() < 1e-9 * (H.norm() * d.norm() + b.norm()));
    } else {
      ++bent;
    }
    // The equations are as they were.
    CHECK(e.factorise(0.0) == Status::ok);
    CHECK((JtJ * e.solution(gain) - b).norm() < 1e-10);
  }
  CHECK(bent > 50 && bent < 350);
}

TEST(SmallNormalEquations, a_tiny_negative_pivot_makes_no_huge_step) {
  NormalEquations<double, 3> e;
  e.clear();
  e.add({1.0, 0.0, 0.0}, 1.0);
  e.add({0.0, 1.0, 0.0}, 1.0);
  e.add({0.0, 0.0, 1.0}, 1.0);
  Mat3 K = Mat3::Zero();
  K(2, 2) = -1.0 - 1e-9;
  bool convex = true;
  CHECK(e.factorise(K, 1e-13, 0.0, convex) == Status::ok);
  CHECK_FALSE(convex);
  double gain = 0.0;
  CHECK((e.solution(gain) - Vec3(1.0, 1.0, 100.0)).norm() < 1e-9);
  K(2, 2) = -1.0;
  CHECK(e.factorise(K, 1e-13, 0.0, convex) == Status::rank_deficient);
}

TEST(SmallNormalEquations, what_leaves_the_range_is_said_and_a_pivot_can_be_kept_in_it) {
  const FixedQ47 zero(0);
  NormalEquations<FixedQ47, 2> e;
  e.clear();
  e.add({FixedQ47(1), zero}, FixedQ47(1));
  e.add({zero, FixedQ47(0.001)}, FixedQ47(0.001));  // a pivot of 1e-6, its inverse above 65536
  CHECK(e.factorise(zero) == Status::not_finite);
  const FixedQ47 least = LeastDivisor<FixedQ47>::value;
  CHECK_FALSE((FixedQ47(1) / least).overflowed());
  CHECK((FixedQ47(1) / (least - FixedQ47::from_raw(1))).overflowed());
  CHECK(e.factorise(zero, least) == Status::ok);
  FixedQ47 gain;
  const auto d = e.solution(gain);
  CHECK(is_sound(d));
  DOUBLES_EQUAL(1.0, static_cast<double>(d(0)), 1e-12);
  DOUBLES_EQUAL(1e-6 * 65536.0, static_cast<double>(d(1)), 1e-6);  // shorter than 1, the same way

  e.add({FixedQ47(300), zero}, zero);  // its square is out of range
  CHECK(e.factorise(zero, least) == Status::not_finite);
}

TEST(SmallNormalEquations, dependent_columns_are_rank_deficient) {
  Generator generator(seed + 1);
  for (int trial = 0; trial < 400; ++trial) {
    Problem p = random_problem(6, generator, 1.0, 0.0);
    NormalEquations<double, 6> e = equations_of<double, 6>(p);
    CHECK(e.factorise(1e-13) == Status::rank_deficient);
    NormalEquations<float, 6> f = equations_of<float, 6>(p);
    CHECK(f.factorise(1e-5F) == Status::rank_deficient);
    NormalEquations<FixedQ47, 6> q = equations_of<FixedQ47, 6>(p);
    CHECK(q.factorise(FixedQ47(1e-11)) == Status::rank_deficient);
    // The same limit lets good ones pass.
    p = random_problem(6, generator, 1.0, 1.0);
    e = equations_of<double, 6>(p);
    CHECK(e.factorise(1e-13) == Status::ok);
  }
}

TEST(SmallNormalEquations, the_limit_is_relative_to_the_diagonal_element) {
  // 1 - rho^2 is what elimination leaves of the last diagonal element, whatever its size.
  for (const double size : {1e-6, 1.0, 1e6}) {
    NormalEquations<double, 3> e;
    e.clear();
    e.add({1.0, 0.0, size}, 0.0);
    e.add({0.0, 1.0, 0.0}, 0.0);
    e.add({0.0, 0.0, 0.01 * size}, 0.0);  // pivot / diagonal = 1e-4 / 1.0001
    CHECK(e.factorise(0.9e-4) == Status::ok);
    CHECK(e.factorise(1.1e-4) == Status::rank_deficient);
  }
}

TEST(SmallNormalEquations, nothing_and_not_a_number_are_rank_deficient) {
  NormalEquations<double, 3> e;
  e.clear();
  CHECK(e.factorise(1e-13) == Status::rank_deficient);
  e.add({1.0, 0.0, 0.0}, 1.0);
  e.add({0.0, std::numeric_limits<double>::quiet_NaN(), 0.0}, 1.0);
  e.add({0.0, 0.0, 1.0}, 1.0);
  CHECK(e.factorise(1e-13) == Status::rank_deficient);
}

TEST(SmallNormalEquations, cost_is_the_sum_of_squares_and_what_was_added) {
  NormalEquations<double, 3> e;
  e.clear();
  e.add({1.0, 0.0, 0.0}, 3.0);
  e.add({0.0, 2.0, 0.0}, -4.0);
  e.add({0.0, 0.0, 4.0}, 1.0);
  e.add_cost(0.5);
  CHECK(e.cost() == 26.5);
  CHECK(e.factorise(1e-13) == Status::ok);
  double gain = 0.0;
  const auto d = e.solution(gain);
  CHECK(d(0) == 3.0);
  CHECK(d(1) == -2.0);
  CHECK(d(2) == 0.25);
  CHECK(gain == 26.0);
  e.clear();
  CHECK(e.cost() == 0.0);
  CHECK(e.factorise(1e-13) == Status::rank_deficient);
}

}  // namespace relnav
