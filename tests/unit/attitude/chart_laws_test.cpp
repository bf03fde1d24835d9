// The laws of AttitudeChart, on every chart.
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "fsw/attitude/attitude_chart.hpp"
#include "fsw/attitude/mrp.hpp"
#include "fsw/attitude/rodrigues.hpp"
#include "fsw/attitude/so3.hpp"
#include "tests/support/numeric_jacobian.hpp"
#include "tests/unit/attitude/attitude_samples.hpp"

#include <CppUTest/TestHarness.h>

namespace relnav {
namespace {

using test::max_difference;
using test::random_vector;

static_assert(AttitudeChart<MrpChart>);
static_assert(AttitudeChart<RodriguesChart>);
static_assert(!AttitudeChart<Vec3>);

// The size that the chart's switching rule bounds by 1.
double switching_size(const MrpChart& chart) { return chart.parameters().norm(); }
double switching_size(const RodriguesChart& chart) { return chart.parameters().cwiseAbs().maxCoeff(); }

Vec3 vee(const Mat3& M) { return 0.5 * Vec3(M(2, 1) - M(1, 2), M(0, 2) - M(2, 0), M(1, 0) - M(0, 1)); }

// Parameters of every set, in and far out of the switching bound, on and beside it, with ties.
template <AttitudeChart Chart>
std::vector<Chart> chart_samples() {
  std::vector<Chart> charts;
  const std::vector<Vec3> directions = {Vec3(1, 0, 0),  Vec3(0, -1, 0), Vec3(0, 0, 1),        Vec3(1, 1, 0),
                                        Vec3(-1, 1, 1), Vec3(1, 1, -1), Vec3(0.3, -0.8, 0.5), Vec3(-0.2, 0.1, -0.9)};
  for (int set = 0; set < Chart::set_count; ++set) {
    charts.push_back(Chart::from_parameters(Vec3::Zero(), set));
    for (const Vec3& direction : directions) {
      const double largest = direction.cwiseAbs().maxCoeff();
      for (const double size : {1e-8, 0.2, 0.9, 1.0 - 1e-9, 1.0, 1.0 + 1e-9, 1.3, 3.0}) {
        charts.push_back(Chart::from_parameters(size / largest * direction, set));
        charts.push_back(Chart::from_parameters(size * direction.normalized(), set));
      }
    }
  }
  return charts;
}

template <AttitudeChart Chart>
std::string name_of(const Chart& chart) {
  const Vec3& p = chart.parameters();
  return "set " + std::to_string(chart.set_index()) + ", p = " + std::to_string(p.x()) + " " + std::to_string(p.y()) +
         " " + std::to_string(p.z());
}

template <AttitudeChart Chart>
void from_dcm_and_back() {
  for (const auto& sample : test::rotation_samples()) {
    const Chart chart = Chart::from_dcm(sample.dcm());
    CHECK_TRUE_TEXT(max_difference(chart.dcm(), sample.dcm()) < 3e-15, sample.name.c_str());
    CHECK_FALSE_TEXT(chart.switch_due(), sample.name.c_str());
    CHECK_TRUE_TEXT(switching_size(chart) <= 1.0 + 1e-15, sample.name.c_str());
  }
  CHECK(Chart().parameters() == Vec3::Zero());
  CHECK(max_difference(Chart().dcm(), Mat3::Identity()) <= 0.0);
}

template <AttitudeChart Chart>
void dcm_is_a_rotation_for_any_parameters() {
  for (const double size : {0.0, 1e-300, 1.0, 1e3, 1e8, 1e99}) {
    for (int set = 0; set < Chart::set_count; ++set) {
      const Mat3 R = Chart::from_parameters(size * Vec3(0.6, -0.64, 0.48), set).dcm();
      CHECK(max_difference(R.transpose() * R, Mat3::Identity()) < 2e-15);
      CHECK(R.determinant() > 0.0);
    }
  }
}

template <AttitudeChart Chart>
void error_jacobian_is_the_derivative_of_the_rotation() {
  for (const Chart& chart : chart_samples<Chart>()) {
    const Mat3 R_CT = chart.dcm();
    const auto error = [&](const Vec3& dp) {
      Chart moved = chart;
      moved.add(dp);
      return vee(moved.dcm() * R_CT.transpose());
    };
    const Vec3 zero = Vec3::Zero();
    const Mat3 A = chart.error_jacobian();
    CHECK_TRUE_TEXT(test::jacobian_error(A, error, zero, 1e-5) < 2e-9, name_of(chart).c_str());
    const Mat3 product = A * chart.error_jacobian_inverse();
    CHECK_TRUE_TEXT(max_difference(product, Mat3::Identity()) < 4e-15, name_of(chart).c_str());
  }
}

template <AttitudeChart Chart>
void kinematics_follow_the_rate_expressed_in_c() {
  const Vec3 omega_C(0.3, -0.7, 0.5);
  for (const Chart& chart : chart_samples<Chart>()) {
    // R' = [omega_C x] R, differentiated along p + p' dt.
    const double dt = 1e-6;
    Chart later = chart;
    Chart earlier = chart;
    later.add(dt * chart.kinematics(omega_C));
    earlier.add(-dt * chart.kinematics(omega_C));
    const Mat3 R_rate = (later.dcm() - earlier.dcm()) / (2.0 * dt);
    CHECK_TRUE_TEXT(max_difference(R_rate, cross_matrix(omega_C) * chart.dcm()) < 2e-9, name_of(chart).c_str());
    // And along the exact motion.
    if (chart.parameters().norm() > 3.9) continue;
    const Vec3 p_rate =
        (chart.rotated(dt * omega_C).parameters() - chart.rotated(-dt * omega_C).parameters()) / (2.0 * dt);
    CHECK_TRUE_TEXT((p_rate - chart.kinematics(omega_C)).norm() < 2e-9, name_of(chart).c_str());
  }
}

template <AttitudeChart Chart>
void rotated_composes_from_the_left() {
  const auto samples = test::rotation_samples();
  for (const auto& start : samples) {
    const Chart chart = Chart::from_dcm(start.dcm());
    for (const auto& step : samples) {
      const Chart result = chart.rotated(step.rotation_vector());
      const std::string name = start.name + ", then " + step.name;
      CHECK_TRUE_TEXT(max_difference(result.dcm(), step.dcm() * start.dcm()) < 6e-15, name.c_str());
      CHECK_TRUE_TEXT(result.parameters().norm() <= same_set_bound * (1.0 + 1e-14), name.c_str());
    }
  }
}

template <AttitudeChart Chart>
void rotated_by_nothing_changes_nothing_and_steps_add_up() {
  Generator generator(21);
  for (int i = 0; i < 2000; ++i) {
    const Chart chart = Chart::from_dcm(exp_so3(random_vector(generator, 3.0)));
    CHECK((chart.rotated(Vec3::Zero()).parameters() - chart.parameters()).norm() < 1e-15);
    const Vec3 a = random_vector(generator, 3.0);
    const Vec3 b = random_vector(generator, 3.0);
    CHECK(max_difference(chart.rotated(a).rotated(b).dcm(), exp_so3(b) * exp_so3(a) * chart.dcm()) < 6e-15);
  }
}

template <AttitudeChart Chart>
void rotated_keeps_the_set_within_its_bound_and_takes_the_best_beyond() {
  // About one axis MRP move as tan(theta / 4), Rodrigues as tan(theta / 2): count where the set is left.
  for (int set = 0; set < Chart::set_count; ++set) {
    const Chart zero = Chart::from_parameters(Vec3::Zero(), set);
    const Vec3 axis = Vec3(0.6, -0.64, 0.48);
    const double angle_at_bound = (Chart::set_count == 2 ? 4.0 : 2.0) * std::atan(same_set_bound);
    const Chart inside = zero.rotated((angle_at_bound - 1e-9) * axis);
    CHECK_EQUAL(set, inside.set_index());
    CHECK(inside.parameters().norm() > same_set_bound - 1e-7);
    const Chart outside = zero.rotated((angle_at_bound + 1e-9) * axis);
    CHECK(outside.set_index() != set);
    CHECK_FALSE(outside.switch_due());
    // On the singularity itself.
    const Chart singular = zero.rotated((Chart::set_count == 2 ? 2.0 : 1.0) * test::pi * axis);
    CHECK(singular.parameters().norm() < 2.0);
    CHECK(max_difference(singular.dcm(), exp_so3((Chart::set_count == 2 ? 2.0 : 1.0) * test::pi * axis) * zero.dcm()) <
          5e-15);
  }
}

template <AttitudeChart Chart>
void rotated_jacobians_equal_the_numeric_ones() {
  const std::vector<Vec3> steps = {Vec3::Zero(),         Vec3(1e-8, 0, -1e-8), Vec3(0.02, -0.05, 0.01),
                                   Vec3(0.1, 0, 0),      Vec3(0.3, 0.2, -0.6), Vec3(-1.5, 0.4, 1.0),
                                   Vec3(0, test::pi, 0), Vec3(3.0, -2.0, 1.0), Vec3(4.0, 3.0, 3.0)};
  int compared = 0;
  int set_changed = 0;
  for (const Chart& chart : chart_samples<Chart>()) {
    for (const Vec3& phi_C : steps) {
      Mat3 J_new_old;
      Mat3 J_new_phi;
      const Chart result = chart.rotated(phi_C, J_new_old, J_new_phi);
      CHECK(result.parameters() == chart.rotated(phi_C).parameters());
      // The numeric derivative needs all its points in the set of the result.
      bool one_set = true;
      const auto of_parameters = [&](const Vec3& p) {
        const Chart moved = Chart::from_parameters(p, chart.set_index()).rotated(phi_C);
        one_set = one_set && moved.set_index() == result.set_index();
        return moved.parameters();
      };
      const auto of_rotation = [&](const Vec3& phi) {
        const Chart moved = chart.rotated(phi);
        one_set = one_set && moved.set_index() == result.set_index();
        return moved.parameters();
      };
      const double error_old = test::jacobian_error(J_new_old, of_parameters, chart.parameters(), 2e-6);
      const double error_phi = test::jacobian_error(J_new_phi, of_rotation, phi_C, 2e-6);
      if (!one_set) continue;
      ++compared;
      if (result.set_index() != chart.set_index()) ++set_changed;
      CHECK_TRUE_TEXT(error_old < 5e-9, name_of(chart).c_str());
      CHECK_TRUE_TEXT(error_phi < 5e-9, name_of(chart).c_str());
    }
  }
  CHECK(compared > 1000);
  CHECK(set_changed > 20);
}

template <AttitudeChart Chart>
void switching_keeps_the_rotation_and_holds_the_bound() {
  int due = 0;
  for (const Chart& chart : chart_samples<Chart>()) {
    Mat3 J;
    Chart after = chart;
    const bool switched = after.switch_if_due(J);
    const std::string name = name_of(chart);
    CHECK_TRUE_TEXT(switched == chart.switch_due(), name.c_str());
    if (switched) {
      ++due;
      CHECK_TRUE_TEXT(switching_size(chart) > 1.0, name.c_str());
      CHECK_TRUE_TEXT(switching_size(after) <= 1.0, name.c_str());
      CHECK_TRUE_TEXT(after.set_index() != chart.set_index(), name.c_str());
    } else {
      CHECK_TRUE_TEXT(switching_size(chart) <= 1.0 + 1e-14, name.c_str());
      CHECK_TRUE_TEXT(after.parameters() == chart.parameters(), name.c_str());
      CHECK_TRUE_TEXT(J == Mat3::Identity(), name.c_str());
    }
    CHECK_TRUE_TEXT(max_difference(after.dcm(), chart.dcm()) < 2e-15, name.c_str());
    CHECK_FALSE_TEXT(after.switch_due(), name.c_str());
  }
  CHECK(due > 40);
}

template <AttitudeChart Chart>
void one_switch_is_enough_whatever_the_size() {
  Generator generator(31);
  for (int i = 0; i < 20000; ++i) {
    // Sizes from a rounding step above the bound to far beyond it.
    const double size = 1.0 + std::pow(10.0, -16.0 + 22.0 * generator.uniform());
    Vec3 p = random_vector(generator, 1.0);
    p *= size / (Chart::set_count == 2 ? p.norm() : p.cwiseAbs().maxCoeff());
    Chart chart = Chart::from_parameters(p, static_cast<int>(generator.below(Chart::set_count)));
    const Mat3 before = chart.dcm();
    Mat3 J;
    const bool was_due = chart.switch_due();
    CHECK_TRUE_TEXT(chart.switch_if_due(J) == was_due, name_of(chart).c_str());
    CHECK_FALSE_TEXT(chart.switch_due(), name_of(chart).c_str());
    CHECK_TRUE_TEXT(switching_size(chart) <= (was_due ? 1.0 : 1.0 + 1e-14), name_of(chart).c_str());
    CHECK_TRUE_TEXT(max_difference(chart.dcm(), before) < 3e-15, name_of(chart).c_str());
  }
}

template <AttitudeChart Chart>
void switch_jacobian_equals_the_numeric_one_and_keeps_the_error() {
  for (const Chart& chart : chart_samples<Chart>()) {
    Mat3 J;
    const Chart after = chart.switched(J);
    const std::string name = name_of(chart);
    if (chart.parameters().norm() < 0.25) {
      CHECK_TRUE_TEXT(after.parameters() == chart.parameters() && after.set_index() == chart.set_index(), name.c_str());
      CHECK_TRUE_TEXT(J == Mat3::Identity(), name.c_str());
      continue;
    }
    CHECK_TRUE_TEXT(max_difference(after.dcm(), chart.dcm()) < 2e-15, name.c_str());
    // The same small rotation, seen from both sets: A_new J = A_old.
    CHECK_TRUE_TEXT(max_difference(after.error_jacobian() * J, chart.error_jacobian()) < 1e-14, name.c_str());
    bool one_set = true;
    const auto of_parameters = [&](const Vec3& p) {
      Mat3 unused;
      const Chart moved = Chart::from_parameters(p, chart.set_index()).switched(unused);
      one_set = one_set && moved.set_index() == after.set_index();
      return moved.parameters();
    };
    const double error = test::jacobian_error(J, of_parameters, chart.parameters(), 1e-6);
    if (one_set) CHECK_TRUE_TEXT(error < 2e-9, name.c_str());
  }
}

template <AttitudeChart Chart>
void any_sequence_of_switches_keeps_the_rotation() {
  for (const auto& sample : test::rotation_samples()) {
    Chart chart = Chart::from_dcm(sample.dcm());
    for (int i = 0; i < 50; ++i) {
      Mat3 J;
      chart = chart.switched(J);
      CHECK_TRUE_TEXT(max_difference(chart.dcm(), sample.dcm()) < 1e-14, sample.name.c_str());
    }
  }
}

template <AttitudeChart Chart>
void a_million_degrees_in_steps_end_where_they_should() {
  // 10000 steps of 100 deg about a fixed axis: 2777 turns and 280 deg. Rounding accumulates, sets do not get lost.
  const Vec3 axis = Vec3(0.6, -0.64, 0.48);
  Chart chart;
  Mat3 J;
  int switches = 0;
  for (int i = 0; i < 10000; ++i) {
    chart = chart.rotated(static_cast<double>(100 * test::pi_l / 180) * axis);
    if (chart.switch_if_due(J)) ++switches;
    CHECK(switching_size(chart) <= 1.0 + 1e-14);
  }
  CHECK(switches > 2000);
  CHECK(max_difference(chart.dcm(), test::reference_dcm(axis, 280 * test::pi_l / 180)) < 2e-12);
}

template <AttitudeChart Chart>
void covariance_follows_the_error_rotation_through_motion_and_switches() {
  // Reference: the covariance of dphi_C itself, which needs no chart: Exp(phi) carries it, J_l Q J_l' drives it.
  Generator generator(41);
  Chart chart = Chart::from_dcm(exp_so3(Vec3(0.5, -0.2, 1.0)));
  Mat3 P_phi = Vec3(1e-4, 4e-4, 2e-5).asDiagonal();
  const Mat3 Q = Vec3(1e-7, 3e-7, 2e-6).asDiagonal();
  const Mat3 A_inverse = chart.error_jacobian_inverse();
  Mat3 P = A_inverse * P_phi * A_inverse.transpose();
  int switches = 0;
  int changes_in_rotated = 0;
  for (int i = 0; i < 20000; ++i) {
    // Now and then a huge step, which rotated() may have to answer in another set.
    const Vec3 phi_C =
        i % 50 == 0 ? random_vector(generator, 3.0) : Vec3(Vec3(0.1, 0.02, -0.05) + random_vector(generator, 0.1));
    Mat3 J_new_old;
    Mat3 J_new_phi;
    const int set = chart.set_index();
    chart = chart.rotated(phi_C, J_new_old, J_new_phi);
    if (chart.set_index() != set) ++changes_in_rotated;
    P = (J_new_old * P * J_new_old.transpose() + J_new_phi * Q * J_new_phi.transpose()).eval();
    Mat3 J_switch;
    if (chart.switch_if_due(J_switch)) ++switches;
    P = (J_switch * P * J_switch.transpose()).eval();

    const Mat3 R_phi = exp_so3(phi_C);
    const Mat3 J_l = left_jacobian_so3(phi_C);
    P_phi = (R_phi * P_phi * R_phi.transpose() + J_l * Q * J_l.transpose()).eval();

    const Mat3 A = chart.error_jacobian();
    const Mat3 carried = A * P * A.transpose();
    CHECK(max_difference(carried, P_phi) < 1e-11 * P_phi.norm());
    CHECK(max_difference(P, P.transpose()) < 1e-11 * P.norm());
  }
  CHECK(switches > 100);
  CHECK(changes_in_rotated > 10);
}

template <AttitudeChart Chart>
void nan_stays_nan_and_traps_nothing() {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  Chart chart = Chart::from_parameters(Vec3(nan, 0.1, 0.2), 1);
  Mat3 J;
  CHECK_FALSE(chart.switch_due());
  CHECK_FALSE(chart.switch_if_due(J));
  CHECK(std::isnan(chart.switched(J).parameters().sum()));
  CHECK(std::isnan(chart.rotated(Vec3(0.1, 0.2, 0.3)).parameters().sum()));
  CHECK(std::isnan(Chart().rotated(Vec3(0.1, nan, 0.3)).parameters().sum()));
  CHECK(std::isnan(Chart::from_dcm(Mat3::Constant(nan)).parameters().sum()));
  CHECK(std::isnan(chart.dcm().sum()));
}

}  // namespace

TEST_GROUP(MrpLaws){};
TEST_GROUP(RodriguesLaws){};

#define LAW(name)                           \
  TEST(MrpLaws, name) { name<MrpChart>(); } \
  TEST(RodriguesLaws, name) { name<RodriguesChart>(); }

LAW(from_dcm_and_back)
LAW(dcm_is_a_rotation_for_any_parameters)
LAW(error_jacobian_is_the_derivative_of_the_rotation)
LAW(kinematics_follow_the_rate_expressed_in_c)
LAW(rotated_composes_from_the_left)
LAW(rotated_by_nothing_changes_nothing_and_steps_add_up)
LAW(rotated_keeps_the_set_within_its_bound_and_takes_the_best_beyond)
LAW(rotated_jacobians_equal_the_numeric_ones)
LAW(switching_keeps_the_rotation_and_holds_the_bound)
LAW(one_switch_is_enough_whatever_the_size)
LAW(switch_jacobian_equals_the_numeric_one_and_keeps_the_error)
LAW(any_sequence_of_switches_keeps_the_rotation)
LAW(a_million_degrees_in_steps_end_where_they_should)
LAW(covariance_follows_the_error_rotation_through_motion_and_switches)
LAW(nan_stays_nan_and_traps_nothing)

}  // namespace relnav
