#include "fsw/estimation/motion_model.hpp"

#include <cmath>

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

TEST_GROUP(MotionModels){};

TEST(MotionModels, F_is_the_jacobian_of_the_step) {
  for_each_state([](const MotionModel& model, const MotionState& at, test::Samples& samples) {
    const Vec3 camera_rate_C = &model == both_models[0] ? samples.matrix<3>(0.3) : Vec3(Vec3::Zero());
    for (const double dt_s : {0.04, 1.0}) {
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
    Eigen::SelfAdjointEigenSolver<Mat12> eigen(Q);
    CHECK(eigen.eigenvalues().minCoeff() > -1e-14);
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

}  // namespace
}  // namespace relnav
