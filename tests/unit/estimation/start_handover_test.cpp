#include "fsw/estimation/start_handover.hpp"

#include <cmath>
#include <memory>

#include "fsw/estimation/inverse_depth.hpp"
#include "tests/support/dense.hpp"
#include "tests/support/numeric_jacobian.hpp"
#include "tests/unit/estimation/estimation_samples.hpp"

#include <CppUTest/TestHarness.h>

namespace relnav {
namespace {

const RigidTargetMotion rigid_target;
constexpr double now_s = 4.0;

}  // namespace

TEST_GROUP(StartHandovers) {
  std::unique_ptr<FilterState> memory = std::make_unique<FilterState>();
  FilterState& state = *memory;
  std::unique_ptr<StartAdjustment::Result> start = std::make_unique<StartAdjustment::Result>();
  test::Samples samples{91};

  /// A start with so many tracks, the features being in the state already under other names.
  void set_up(AttitudeChartKind chart, double rate_rad_s, int features) {
    state.reset(samples.motion(chart, 0.1), Mat12::Identity());
    start->theta = samples.matrix<12>(0.02);
    start->theta.head<3>() += Vec3(0.1, -0.1, 4.0);
    start->theta.segment<3>(6) = rate_rad_s * samples.matrix<3>().normalized();
    start->theta.tail<3>() *= 0.05;
    start->covariance = samples.covariance<12>(0.01);
    start->thetas.fill(start->theta);
    start->weights = {1.0, 0.0, 0.0};
    for (int i = 0; i < features; ++i) {
      const Expected<SlotHandle> slot = state.add(samples.feature(), Mat<6, 12>::Zero(), {}, Mat6::Identity());
      CHECK(slot.has_value());
      StartAdjustment::TrackResult& t = start->tracks[slot.value().index];
      t.p = samples.within({-0.2, -0.2, 0.22}, {0.2, 0.2, 0.28});
      t.dp_dtheta = samples.matrix<3, 12>(0.1);
      t.covariance = samples.covariance<3>(0.01);
      t.t_s = i % 3 == 0 ? 0.0 : samples.uniform(0.0, now_s);
    }
  }
  void take_over(AttitudeChartKind chart) { take_over_start(*start, now_s, chart, state); }
};

TEST(StartHandovers, every_point_is_where_its_track_says) {
  for (const AttitudeChartKind chart : test::both_charts) {
    for (const double rate : {0.0, 0.05, 0.8}) {
      set_up(chart, rate, 8);
      take_over(chart);
      const StartBundle::Theta& theta = start->theta;
      for (const Feature& f : state.features()) {
        const StartAdjustment::TrackResult& t = start->tracks[f.slot.index];
        const Mat3 R = exp_so3(Vec3(t.t_s * theta.segment<3>(6) + 0.5 * t.t_s * t.t_s * theta.segment<3>(9)));
        const Vec3 c = theta.head<3>() + t.t_s * theta.segment<3>(3);
        const Vec3 expected_T = R.transpose() * (Vec3(t.p(0), t.p(1), 1.0) / t.p(2) - c);
        Mat<3, 6> ignored;
        CHECK((inverse_depth::point_T(f.y, ignored) - expected_T).norm() < 1e-12);
        CHECK((f.R_CT0 - R).norm() < 1e-14 && (f.r_TC0 + R.transpose() * c).norm() < 1e-13);
        LONGS_EQUAL(6, f.size);
      }
    }
  }
}

TEST(StartHandovers, covariance_is_that_of_theta_and_the_tracks_through_the_numeric_jacobian) {
  constexpr int features = 3;
  constexpr int inputs = 12 + 3 * features;
  constexpr int states = 12 + 6 * features;
  for (const AttitudeChartKind chart : test::both_charts) {
    for (const double rate : {0.0, 0.05, 0.5}) {
      set_up(chart, rate, features);
      const StartAdjustment::Result at = *start;
      take_over(chart);
      const Eigen::MatrixXd P = test::dense_covariance(state);
      std::array<std::size_t, features> slot{};
      for (std::size_t i = 0; i < features; ++i) slot[i] = state.features()[i].slot.index;

      // Everything that is known, as one vector: theta, and each track's deviation from its conditional mean.
      const auto states_of = [&](const Mat<inputs>& d) -> Mat<states> {
        *start = at;
        start->theta += d.head<12>();
        for (std::size_t i = 0; i < features; ++i) {
          StartAdjustment::TrackResult& t = start->tracks[slot[i]];
          t.p += t.dp_dtheta * d.head<12>() + d.segment<3>(12 + 3 * static_cast<int>(i));
        }
        take_over(chart);
        Mat<states> x;
        x.head<12>() << state.motion.position, state.motion.attitude.parameters(), state.motion.velocity,
            state.motion.rate;
        for (int i = 0; i < features; ++i) {
          x.segment<6>(12 + 6 * i) = state.features()[static_cast<std::size_t>(i)].y;
        }
        return x;
      };
      const Mat<states, inputs> J = test::numeric_jacobian<states, inputs>(states_of, Mat<inputs>::Zero(), 1e-6);
      Mat<inputs, inputs> known = Mat<inputs, inputs>::Zero();
      known.topLeftCorner<12, 12>() = at.covariance;
      for (int i = 0; i < features; ++i) {
        known.block<3, 3>(12 + 3 * i, 12 + 3 * i) = at.tracks[slot[static_cast<std::size_t>(i)]].covariance;
      }
      const Eigen::MatrixXd expected = test::congruence(J, known);
      CHECK((P - expected).cwiseAbs().maxCoeff() < 1e-8 * expected.cwiseAbs().maxCoeff());
    }
  }
}

TEST(StartHandovers, a_blend_of_one_hypothesis_changes_nothing) {
  set_up(AttitudeChartKind::mrp, 0.1, 2);
  take_over(AttitudeChartKind::mrp);
  RelativeState out;
  out.pose_covariance = samples.covariance<6>();
  out.rate_covariance = samples.covariance<6>();
  const RelativeState before = out;
  blend_start_hypotheses(*start, now_s, out);
  const PoseLinearisation pose = rigid_target.pose(state.motion);
  CHECK((out.R_CT - pose.R_CT).norm() < 1e-14 && (out.t_CT - pose.t_CT).norm() < 1e-14);
  CHECK((out.omega_C - state.motion.rate).norm() < 1e-15 && (out.v_C - state.motion.velocity).norm() < 1e-15);
  CHECK(out.pose_covariance == before.pose_covariance && out.rate_covariance == before.rate_covariance);
}

TEST(StartHandovers, a_blend_is_mean_and_covariance_of_the_mixture) {
  set_up(AttitudeChartKind::mrp, 0.1, 0);
  // Turning one way or the other, equally likely: nothing is known of the sign, and the covariance says so.
  start->thetas[0] = start->theta;
  start->thetas[1] = start->theta;
  start->thetas[1].tail<6>() = -start->theta.tail<6>();
  start->weights = {0.5, 0.5, 0.0};
  RelativeState out;
  out.pose_covariance.setZero();
  out.rate_covariance.setZero();
  blend_start_hypotheses(*start, now_s, out);
  CHECK((out.R_CT - Mat3::Identity()).norm() < 1e-15);
  CHECK(out.omega_C.norm() < 1e-17);
  const Vec3 rate = start->theta.segment<3>(6) + now_s * start->theta.segment<3>(9);
  const Mat3 expected = rate * rate.transpose();
  CHECK((out.rate_covariance.block<3, 3>(3, 3) - expected).norm() < 1e-15);
  CHECK((out.rate_covariance.topLeftCorner<3, 3>().norm() < 1e-17));
  const Vec3 turned = now_s * start->theta.segment<3>(6) + 0.5 * now_s * now_s * start->theta.segment<3>(9);
  CHECK((out.pose_covariance.block<3, 3>(3, 3) - turned * turned.transpose()).norm() < 1e-15);
}

}  // namespace relnav
