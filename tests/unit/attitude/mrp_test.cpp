#include "fsw/attitude/mrp.hpp"

#include <cmath>

#include "fsw/attitude/so3.hpp"
#include "tests/unit/attitude/attitude_samples.hpp"

#include <CppUTest/TestHarness.h>

namespace relnav {

TEST_GROUP(Mrp){};

TEST(Mrp, parameters_are_axis_times_tangent_of_a_quarter_of_the_angle) {
  for (const auto& sample : test::rotation_samples()) {
    if (std::fabs(sample.angle) > test::pi_l - 1e-10L) continue;
    const Vec3 expected = static_cast<double>(std::tan(sample.angle / 4)) * sample.axis.normalized();
    CHECK_TRUE_TEXT((MrpChart::from_dcm(sample.dcm()).parameters() - expected).norm() < 1e-15, sample.name.c_str());
  }
}

TEST(Mrp, kinematics_are_the_papers_formula_seen_from_the_other_side) {
  const Vec3 sigma(0.2, -0.5, 0.4);
  const Vec3 omega_C(0.01, 0.03, -0.02);
  const Vec3 s = -sigma;  // of C relative to T
  const Vec3 omega = -omega_C;
  const Vec3 s_dot =
      0.25 * ((1.0 - s.squaredNorm()) * Mat3::Identity() + 2.0 * cross_matrix(s) + 2.0 * s * s.transpose()) * omega;
  CHECK((MrpChart::from_parameters(sigma, 0).kinematics(omega_C) + s_dot).norm() < 1e-17);
}

TEST(Mrp, shadow_set_is_minus_sigma_over_its_square) {
  Mat3 J;
  const MrpChart shadow = MrpChart::from_parameters(Vec3(0.0, 2.0, 0.0), 0).switched(J);
  CHECK((shadow.parameters() - Vec3(0.0, -0.5, 0.0)).norm() < 1e-16);
  CHECK_EQUAL(1, shadow.set_index());
  CHECK_EQUAL(0, shadow.switched(J).set_index());
}

TEST(Mrp, at_exactly_180_degrees_no_switch_is_due_and_both_sets_serve) {
  for (const Vec3& axis : {Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, -1), Vec3(0.6, -0.64, 0.48)}) {
    const MrpChart chart = MrpChart::from_parameters(axis, 0);
    CHECK_FALSE(chart.switch_due());
    Mat3 J;
    const MrpChart shadow = chart.switched(J);
    CHECK((shadow.parameters() + axis).norm() < 1e-15);
    CHECK_FALSE(shadow.switch_due());
    CHECK(test::max_difference(shadow.dcm(), chart.dcm()) < 1e-15);
  }
}

TEST(Mrp, a_slow_turn_through_180_degrees_switches_once) {
  MrpChart chart = MrpChart::from_dcm(exp_so3(Vec3(0.0, 0.0, test::pi - 1e-3)));
  int switches = 0;
  Mat3 J;
  for (int i = 0; i < 2000; ++i) {
    chart = chart.rotated(Vec3(0.0, 0.0, 1e-6));
    if (chart.switch_if_due(J)) ++switches;
  }
  CHECK_EQUAL(1, switches);
}

}  // namespace relnav
