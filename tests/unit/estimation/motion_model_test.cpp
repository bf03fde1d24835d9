#include "fsw/estimation/motion_model.hpp"

#include <cmath>
#include <limits>

#include "tests/support/dense.hpp"
#include "tests/support/numeric_jacobian.hpp"
#include "tests/unit/estimation/estimation_samples.hpp"

#include <CppUTest/TestHarness.h>

namespace relnav {
namespace {

const RigidTargetMotion rigid_target;
const CameraMotion moving_camera;
const MotionModel* const both_models[] = {&rigid_target, &moving_camera};

Mat<12> states_of(const MotionState& m) {
  Mat<12> x;
  x << m.position, m.attitude.parameters(), m.velocity, m.rate;
  return x;
}

template <typename Check>
void for_each_state(const Check& check) {
  test::Samples samples(31);
  for (const MotionModel* model : both_models) {
    for (const AttitudeChartKind chart : test::both_charts) {
      for (const double angle : test::attitude_angles) {
        for (int i = 0; i < 4; ++i) check(*model, samples.motion(chart, angle), samples);
      }
    }
  }
}

void check_F(const MotionModel& model, const MotionState& at, double dt_s, const Vec3& camera_rate_C) {
  Mat12 F;
  Mat12 Q;
  MotionState next = at;
  model.propagate(next, dt_s, {}, camera_rate_C, F, Q);
  CHECK(Q == Mat12::Zero());
  const auto step = [&](const Mat<12>& dx) -> Mat<12> {
    MotionState m = test::moved(at, dx);
    Mat12 ignored[2];
    model.propagate(m, dt_s, {}, camera_rate_C, ignored[0], ignored[1]);
    return states_of(m);
  };
  CHECK((test::jacobian_error<12, 12>(F, step, Mat<12>::Zero()) < 2e-8));
}

}  // namespace

TEST_GROUP(MotionModels){};

namespace {

TEST(MotionModels, F_is_the_jacobian_of_the_step) {
  for_each_state([](const MotionModel& model, const MotionState& at, test::Samples& samples) {
    const Vec3 camera_rate_C = &model == both_models[0] ? samples.matrix<3>(0.3) : Vec3(Vec3::Zero());
    for (const double dt_s : {0.04, 1.0}) check_F(model, at, dt_s, camera_rate_C);
  });
}

TEST(MotionModels, rigid_target_step_is_exact_for_constant_inertial_rates) {
  test::Samples samples(32);
  for (int i = 0; i < 20; ++i) {
    MotionState one = samples.motion(AttitudeChartKind::mrp, 1.0);
    const MotionState before = one;
    const Vec3 camera_rate_C = samples.matrix<3>(0.3);
    Mat12 ignored[2];
    rigid_target.propagate(one, 0.7, {}, camera_rate_C, ignored[0], ignored[1]);
    // In the inertial frame that C is now: the target's centre moves straight, the target turns about its rate.
    const Mat3 R_now_then = exp_so3(Vec3(-0.7 * camera_rate_C));
    const Vec3 t = R_now_then * (before.position + 0.7 * before.velocity);
    const Mat3 R = R_now_then * exp_so3(Vec3(0.7 * before.rate)) * before.attitude.dcm();
    CHECK((one.position - t).norm() < 1e-14);
    CHECK((one.attitude.dcm() - R).norm() < 1e-14);
    CHECK((one.velocity - R_now_then * before.velocity).norm() < 1e-15);
    CHECK((one.rate - R_now_then * before.rate).norm() < 1e-15);
    // Many small steps arrive where one large one does.
    MotionState many = before;
    for (int k = 0; k < 7; ++k) rigid_target.propagate(many, 0.1, {}, camera_rate_C, ignored[0], ignored[1]);
    CHECK((states_of(many) - states_of(one)).norm() < 1e-13);
  }
}

TEST(MotionModels, Q_is_symmetric_and_not_negative) {
  for_each_state([](const MotionModel& model, MotionState at, test::Samples& samples) {
    Mat12 F;
    Mat12 Q;
    model.propagate(at, 0.3, {0.2, 0.05}, samples.matrix<3>(0.1), F, Q);
    CHECK((Q - Q.transpose()).cwiseAbs().maxCoeff() < 1e-16);
    CHECK(test::eigenvalues_of(Q).minCoeff() > -1e-14);
  });
}

TEST(MotionModels, Q_of_position_and_velocity_is_that_of_white_acceleration) {
  for_each_state([](const MotionModel& model, MotionState at, test::Samples&) {
    const double q = 0.2 * 0.2;
    const double w = 0.05 * 0.05;
    const double dt_s = 0.3;
    Mat12 F;
    Mat12 Q;
    model.propagate(at, dt_s, {0.2, 0.05}, Vec3::Zero(), F, Q);
    const Mat3 I = Mat3::Identity();
    CHECK((Q.block<3, 3>(0, 0) - q * dt_s * dt_s * dt_s / 3.0 * I).norm() < 1e-17);
    CHECK((Q.block<3, 3>(0, 6) - q * dt_s * dt_s / 2.0 * I).norm() < 1e-17);
    CHECK((Q.block<3, 3>(6, 6) - q * dt_s * I).norm() < 1e-17);
    CHECK((Q.block<3, 3>(9, 9) - w * dt_s * I).norm() < 1e-17);
    // Attitude and rate seen as dphi of C.
    const Mat3 A = at.attitude.error_jacobian();
    const Mat3 phi = A * Q.block<3, 3>(3, 3) * A.transpose();
    CHECK((phi - w * dt_s * dt_s * dt_s / 3.0 * I).norm() < 0.1 * w * dt_s * dt_s * dt_s);
    CHECK((Q.block<3, 3>(0, 3)).isZero(0.0));
    CHECK((Q.block<3, 3>(6, 9)).isZero(0.0));
  });
}

TEST(MotionModels, pose_jacobian_is_that_of_the_pose) {
  for_each_state([](const MotionModel& model, const MotionState& at, test::Samples&) {
    const PoseLinearisation pose = model.pose(at);
    const auto error = [&](const Vec6& dx) -> Vec6 {
      Mat<12> d = Mat<12>::Zero();
      d.head<6>() = dx;
      const PoseLinearisation there = model.pose(test::moved(at, d));
      Vec6 e;
      e << there.t_CT - pose.t_CT, log_so3(there.R_CT * pose.R_CT.transpose());
      return e;
    };
    CHECK((test::jacobian_error<6, 6>(pose.J, error, Vec6::Zero()) < 1e-8));
  });
}

TEST(MotionModels, rates_and_their_jacobian_are_those_of_the_pose) {
  for_each_state([](const MotionModel& model, const MotionState& at, test::Samples&) {
    Vec3 v_C;
    Vec3 omega_C;
    Mat<6, 12> J;
    model.rates(at, v_C, omega_C, J);
    const auto rates = [&](const Mat<12>& dx) -> Vec6 {
      Vec6 r;
      Vec3 v;
      Vec3 w;
      Mat<6, 12> ignored;
      model.rates(test::moved(at, dx), v, w, ignored);
      r << v, w;
      return r;
    };
    CHECK((test::jacobian_error<6, 12>(J, rates, Mat<12>::Zero()) < 1e-8));

    const auto pose_after = [&](double dt_s) {
      MotionState m = at;
      Mat12 ignored[2];
      model.propagate(m, dt_s, {}, Vec3::Zero(), ignored[0], ignored[1]);
      return model.pose(m);
    };
    constexpr double h = 1e-5;
    const PoseLinearisation after = pose_after(h);
    const PoseLinearisation before = pose_after(-h);
    CHECK(((after.t_CT - before.t_CT) / (2.0 * h) - v_C).norm() < 1e-8);
    CHECK((log_so3(after.R_CT * before.R_CT.transpose()) / (2.0 * h) - omega_C).norm() < 1e-8);
  });
}

TEST(MotionModels, at_rest_means_the_pose_it_was_given) {
  test::Samples samples(33);
  for (const MotionModel* model : both_models) {
    for (const AttitudeChartKind chart : test::both_charts) {
      const Mat3 R = samples.attitude(2.0);
      const Vec3 t = samples.matrix<3>(5.0);
      const MotionState m = model->at_rest(chart, R, t);
      CHECK(m.attitude.kind() == chart);
      CHECK((model->pose(m).R_CT - R).norm() < 1e-14);
      CHECK((model->pose(m).t_CT - t).norm() < 1e-14);
      CHECK(m.velocity.isZero(0.0) && m.rate.isZero(0.0));
    }
  }
}

// ---- unequal moments of inertia ----

const InertiaRatios sample_inertias[] = {
    {1.3, 0.8, Vec3(0.3, -0.5, 0.2)}, {2.0, 2.0, Vec3::Zero()}, {0.6, 0.5, Vec3(1.0, 1.0, -2.0)}};

Vec3 momentum_C(const InertiaRatios& inertia, const MotionState& m) {
  const Mat3 R_CP = m.attitude.dcm() * exp_so3(inertia.phi_TP);
  return R_CP * Vec3(1.0, inertia.second, inertia.third).asDiagonal() * (R_CP.transpose() * m.rate);
}

TEST(MotionModels, F_of_a_tumbling_target_is_the_jacobian_of_the_step) {
  test::Samples samples(34);
  for (const InertiaRatios& inertia : sample_inertias) {
    const RigidTargetMotion tumbling(inertia);
    for (const AttitudeChartKind chart : test::both_charts) {
      for (const double angle : test::attitude_angles) {
        for (const double dt_s : {0.04, 0.37}) {  // one step and eight
          check_F(tumbling, samples.motion(chart, angle), dt_s, samples.matrix<3>(0.3));
        }
      }
    }
  }
}

TEST(MotionModels, a_tumbling_target_keeps_its_momentum_and_converges_with_the_step) {
  test::Samples samples(35);
  for (const InertiaRatios& inertia : sample_inertias) {
    const RigidTargetMotion tumbling(inertia);
    for (int i = 0; i < 5; ++i) {
      MotionState start = samples.motion(AttitudeChartKind::mrp, 1.0);
      start.rate = 5.0 * test::degree * samples.matrix<3>().normalized();
      const Vec3 before = momentum_C(inertia, start);
      const auto after_10_s = [&](int steps) {
        MotionState m = start;
        Mat12 ignored[2];
        Mat3 switched;
        for (int k = 0; k < steps; ++k) {
          tumbling.propagate(m, 10.0 / steps, {}, Vec3::Zero(), ignored[0], ignored[1]);
          (void)m.attitude.switch_if_due(switched);
        }
        return m;
      };
      const MotionState fine = after_10_s(4000);
      const MotionState frames = after_10_s(100);
      const MotionState half = after_10_s(400);
      CHECK((momentum_C(inertia, frames) - before).norm() < 2e-3 * before.norm());
      const double error = log_so3(frames.attitude.dcm() * fine.attitude.dcm().transpose()).norm();
      const double error_of_half = log_so3(half.attitude.dcm() * fine.attitude.dcm().transpose()).norm();
      CHECK(error < 0.05 * test::degree);          // over 50 deg turned
      CHECK(error_of_half < 0.7 * error + 1e-12);  // max_step_s 0.05 against 0.025
      CHECK((frames.rate - fine.rate).norm() < 0.01 * test::degree);
    }
  }
}

TEST(MotionModels, equal_moments_turn_as_a_constant_rate_does) {
  test::Samples samples(36);
  const RigidTargetMotion nearly_equal(InertiaRatios{1.0 + 1e-12, 1.0, Vec3(0.1, 0.2, 0.3)});
  for (const AttitudeChartKind chart : test::both_charts) {
    MotionState a = samples.motion(chart, 1.0);
    MotionState b = a;
    Mat12 F_a;
    Mat12 F_b;
    Mat12 Q;
    rigid_target.propagate(a, 0.1, {}, Vec3::Zero(), F_a, Q);
    nearly_equal.propagate(b, 0.1, {}, Vec3::Zero(), F_b, Q);
    CHECK((states_of(a) - states_of(b)).norm() < 1e-11);
    CHECK((F_a - F_b).norm() < 1e-9);
  }
}

TEST(MotionModels, moments_of_inertia_that_no_body_has_are_told) {
  CHECK(InertiaRatios{}.is_physical() && InertiaRatios{}.is_sphere());
  for (const InertiaRatios& inertia : sample_inertias) CHECK(inertia.is_physical() && !inertia.is_sphere());
  const Vec3 zero = Vec3::Zero();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const InertiaRatios impossible[] = {
      {0.0, 1.0, zero}, {-1.0, 1.0, zero}, {2.1, 1.0, zero},      {1.0, 2.1, zero},
      {0.4, 0.5, zero}, {nan, 1.0, zero},  {1.0, HUGE_VAL, zero}, {1.0, 1.0, Vec3(0.0, nan, 0.0)}};
  for (const InertiaRatios& inertia : impossible) CHECK_FALSE(inertia.is_physical());
}

}  // namespace
}  // namespace relnav
