// The equations of Yue, Hou 2010 as printed (cooperative-mono.md), against RodriguesChart.
#include "fsw/attitude/rodrigues.hpp"

#include <Eigen/Geometry>
#include <cmath>

#include "fsw/attitude/so3.hpp"
#include "tests/unit/attitude/attitude_samples.hpp"

#include <CppUTest/TestHarness.h>

namespace relnav {
namespace {

using test::max_difference;

// (3)
Mat3 dcm_as_printed(const Vec3& g) {
  const double g2 = g.squaredNorm();
  return ((1.0 - g2) * Mat3::Identity() + 2.0 * g * g.transpose() - 2.0 * cross_matrix(g)) / (1.0 + g2);
}

// (4)
Mat3 set_rotation(int i) {
  Vec3 d = Vec3::Ones();
  if (i != 0) {
    d = -d;
    d[i - 1] = 1.0;
  }
  return d.asDiagonal();
}

// (5)
Vec3 switch_as_printed(const Vec3& g, int j) {
  if (j == 1) return Vec3(-1.0, g[2], -g[1]) / g[0];
  if (j == 2) return Vec3(-g[2], -1.0, g[0]) / g[1];
  return Vec3(g[1], -g[0], -1.0) / g[2];
}

int index_as_printed(int i, int j) { return i == 0 ? j : (i == j ? 0 : 6 - j - i); }

}  // namespace

TEST_GROUP(Rodrigues){};

TEST(Rodrigues, dcm_is_c_of_g_times_the_sets_rotation) {
  Generator generator(3);
  for (int k = 0; k < 1000; ++k) {
    const Vec3 g = test::random_vector(generator, 2.0);
    const int set = k % 4;
    const Mat3 expected = dcm_as_printed(g) * set_rotation(set);
    CHECK(max_difference(RodriguesChart::from_parameters(g, set).dcm(), expected) < 2e-15);
  }
}

TEST(Rodrigues, parameters_are_shusters_gibbs_vector) {
  // Passive: an active turn by +theta about n has g = -n tan(theta / 2).
  const RodriguesChart chart = RodriguesChart::from_dcm(exp_so3(Vec3(0.0, 0.0, 0.4)));
  CHECK_EQUAL(0, chart.set_index());
  CHECK((chart.parameters() - Vec3(0.0, 0.0, -std::tan(0.2))).norm() < 1e-16);
}

TEST(Rodrigues, switch_is_the_printed_one_for_the_largest_component) {
  Generator generator(4);
  for (int k = 0; k < 4000; ++k) {
    const Vec3 g = test::random_vector(generator, 3.0);
    if (g.norm() < 0.25) continue;
    const int set = k % 4;
    int j = 0;
    g.cwiseAbs().maxCoeff(&j);
    Mat3 J;
    const RodriguesChart after = RodriguesChart::from_parameters(g, set).switched(J);
    CHECK_EQUAL(index_as_printed(set, j + 1), after.set_index());
    CHECK((after.parameters() - switch_as_printed(g, j + 1)).norm() < 1e-15 * (1.0 + after.parameters().norm()));
  }
}

TEST(Rodrigues, from_dcm_takes_the_set_of_the_nearest_half_turn) {
  for (int set = 0; set < 4; ++set) {
    const RodriguesChart chart = RodriguesChart::from_dcm(set_rotation(set));
    CHECK_EQUAL(set, chart.set_index());
    CHECK(chart.parameters().norm() <= 0.0);
  }
}

TEST(Rodrigues, rotated_is_the_printed_composition_in_every_set) {
  // (10): a * b = (a + b - a x b) / (1 - a.b), with a the parameters of the step.
  Generator generator(8);
  for (int k = 0; k < 4000; ++k) {
    const Vec3 b = test::random_vector(generator, 1.0);
    const Vec3 phi_C = test::random_vector(generator, 0.3);
    const Vec3 a = -std::tan(0.5 * phi_C.norm()) * phi_C.normalized();
    const Vec3 expected = (a + b - a.cross(b)) / (1.0 - a.dot(b));
    const RodriguesChart result = RodriguesChart::from_parameters(b, k % 4).rotated(phi_C);
    CHECK_EQUAL(k % 4, result.set_index());
    CHECK((result.parameters() - expected).norm() < 3e-15);
  }
}

TEST(Rodrigues, jacobians_are_bounded_by_2_within_the_switching_bound) {
  Generator generator(9);
  for (int k = 0; k < 4000; ++k) {
    Vec3 g = test::random_vector(generator, 1.0);
    if (k < 8) g = Vec3(k & 1 ? 1 : -1, k & 2 ? 1 : -1, k & 4 ? 1 : -1);
    const RodriguesChart chart = RodriguesChart::from_parameters(g, k % 4);
    const Vec3 v = test::random_vector(generator, 1.0).normalized();
    CHECK((chart.error_jacobian() * v).norm() <= 2.0 + 1e-15);
    CHECK((chart.error_jacobian_inverse() * v).norm() <= 2.0 + 1e-15);
  }
}

}  // namespace relnav
