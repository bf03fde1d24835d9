#include "fsw/estimation/noncoop_filter.hpp"

#include <cmath>
#include <cstdio>
#include <functional>
#include <limits>
#include <memory>
#include <string>

#include "tests/support/campaign.hpp"
#include "tests/support/dense.hpp"
#include "tests/unit/estimation/filter_run.hpp"

#include <CppUTest/TestHarness.h>

namespace relnav {
namespace {

constexpr int frames_of_both_charts = test::campaign(200, 40);
constexpr int warm_up = test::campaign(80, 45);  // frames
constexpr std::uint64_t camera_runs = test::campaign<std::uint64_t>(3, 1);

NoncoopConfig near_target() {
  NoncoopConfig c = NoncoopConfig::defaults(MotionKind::rigid_target);
  c.range_m = 3.4;
  c.start_pixel_sigma_px = 0.3;
  return c;
}

test::TargetMotion turning_at(const Vec3& rate_deg_s) {
  test::TargetMotion m;
  m.t_CB0 = Vec3(0.0, 0.0, 3.4);
  m.R_CB0 = exp_so3(Vec3(0.3, -0.2, 0.4));
  m.omega_C = test::degree * rate_deg_s;
  return m;
}

double degrees(double rad) { return rad / test::degree; }

}  // namespace

TEST_GROUP(NoncoopFilters){};

namespace {

TEST(NoncoopFilters, configure_refuses_what_makes_no_sense) {
  using Member = double NoncoopConfig::*;
  struct Named {
    const char* name;
    Member member;
    bool zero_is_valid;
  };
  const Named members[] = {
      {"range_m", &NoncoopConfig::range_m, false},
      {"range_sigma_m", &NoncoopConfig::range_sigma_m, true},
      {"rate_sigma_rad_s", &NoncoopConfig::rate_sigma_rad_s, true},
      {"velocity_sigma_per_range", &NoncoopConfig::velocity_sigma_per_range, true},
      {"acceleration_psd_per_range", &NoncoopConfig::acceleration_psd_per_range, true},
      {"angular_psd", &NoncoopConfig::angular_psd, true},
      {"relief_per_extent", &NoncoopConfig::relief_per_extent, true},
      {"min_relief", &NoncoopConfig::min_relief, true},
      {"pixel_sigma_px", &NoncoopConfig::pixel_sigma_px, false},
      {"first_view_sigma_px", &NoncoopConfig::first_view_sigma_px, false},
      {"feature_walk_px2_per_deg", &NoncoopConfig::feature_walk_px2_per_deg, true},
      {"robust_sigma", &NoncoopConfig::robust_sigma, true},
      {"gate_chi2", &NoncoopConfig::gate_chi2, false},
      {"linearity_threshold", &NoncoopConfig::linearity_threshold, true},
      {"start_duration_s", &NoncoopConfig::start_duration_s, true},
  };
  constexpr double infinity = std::numeric_limits<double>::infinity();
  auto filter = std::make_unique<NoncoopFilter>();
  for (const MotionKind motion : {MotionKind::rigid_target, MotionKind::camera}) {
    CHECK(filter->configure(NoncoopConfig::defaults(motion), test::sample_camera()) == Status::ok);
    for (const Named& m : members) {
      for (const double bad : {-1e-3, infinity, -infinity, std::numeric_limits<double>::quiet_NaN(), 0.0}) {
        if (bad == 0.0 && m.zero_is_valid) continue;
        NoncoopConfig c = NoncoopConfig::defaults(motion);
        c.*m.member = bad;
        const std::string text = std::string(m.name) + " = " + std::to_string(bad);
        CHECK_TRUE_TEXT(filter->configure(c, test::sample_camera()) == Status::invalid_argument, text.c_str());
        LONGS_EQUAL_TEXT(static_cast<int>(motion), static_cast<int>(filter->config().motion), "kept");
      }
    }
  }
}

TEST(NoncoopFilters, time_goes_forward_only) {
  test::FilterRun run(near_target(), turning_at(Vec3(0.0, 2.0, 0.0)), 0.0, 1, 0.1);
  for (int k = 0; k < 3; ++k) run.step();
  NoncoopFilter& filter = run.filter();
  const RelativeState before = filter.output();
  for (const std::int64_t back_ns : {0LL, 1LL, 1'000'000'000LL}) {
    CHECK(filter.predict(Time{before.time.ns - back_ns}) == Status::out_of_order);
    CHECK(filter.output().time == before.time);
    CHECK(filter.output().t_CT == before.t_CT && filter.output().R_CT == before.R_CT);
    CHECK(filter.output().pose_covariance == before.pose_covariance);
  }
  CHECK(filter.predict(Time{before.time.ns + 1}) == Status::ok);
}

TEST(NoncoopFilters, both_charts_give_the_same_trajectory) {
  NoncoopConfig config = near_target();
  const test::TargetMotion motion = turning_at(Vec3(1.0, 2.0, -1.0));
  config.chart = AttitudeChartKind::mrp;
  // Two filters are too large for the stack of a board.
  const auto mrp = std::make_unique<test::FilterRun>(config, motion, 0.3, 7, 0.1);
  config.chart = AttitudeChartKind::rodrigues;
  const auto rodrigues = std::make_unique<test::FilterRun>(config, motion, 0.3, 7, 0.1);
  double worst = 0.0;  // Mahalanobis distance of the two poses
  for (int k = 0; k < frames_of_both_charts; ++k) {
    mrp->step();
    rodrigues->step();
    const RelativeState a = mrp->filter().output();
    const RelativeState b = rodrigues->filter().output();
    Vec6 apart;
    apart << a.t_CT - b.t_CT, log_so3(a.R_CT * b.R_CT.transpose());
    worst = std::max(worst, std::sqrt(test::mahalanobis_squared(apart, a.pose_covariance)));
  }
  // Corrections are added in the chart: terms of second order differ, and with them, once in a while, a verdict on a match.
  std::printf("  charts apart by at most %.2f sigma\n", worst);
  CHECK(worst < 0.5);
}

TEST(NoncoopFilters, a_target_turned_beyond_180_degrees_is_not_lost_when_the_chart_switches) {
  for (const AttitudeChartKind chart : test::both_charts) {
    NoncoopConfig config = near_target();
    config.chart = chart;
    config.rate_sigma_rad_s = 20.0 * test::degree;
    constexpr double step_s = test::campaign(0.05, 0.1);
    test::FilterRun run(config, turning_at(Vec3(3.0, 19.5, 2.0)), 0.3, 3, step_s);
    int switches = 0;
    int least_inliers = 1000;
    double worst = 0.0;
    double jump = 0.0;
    Vec3 error_before = Vec3::Zero();
    for (int k = 0; k * step_s < 16.0; ++k) {  // about 320 deg: past the next switch of either chart
      run.step();
      const RelativeState out = run.filter().output();
      const Vec3 error = run.attitude_error(out);
      if (run.last().chart_switched) {
        ++switches;
        jump = std::max(jump, (error - error_before).norm());
      }
      error_before = error;
      if (k * step_s >= 3.0) worst = std::max(worst, error.norm());
      least_inliers = std::min(least_inliers, run.last().inliers);
      CHECK(run.last().status == Status::ok);
      CHECK(test::eigenvalues_of(out.pose_covariance).minCoeff() > 0.0);
    }
    std::printf(
        "  chart %d: %d switches, at most %.2f deg off (last %.2f), %.3f deg in a switch's frame, at least %d "
        "inliers\n",
        static_cast<int>(chart), switches, degrees(worst), degrees(error_before.norm()), degrees(jump), least_inliers);
    CHECK(switches >= 1);
    CHECK(least_inliers >= 15);
    CHECK(degrees(worst) < 5.0);
    CHECK(degrees(jump) < 0.5);
  }
}

TEST(NoncoopFilters, camera_motion_tracks_a_scene_at_rest) {
  NoncoopConfig config = NoncoopConfig::defaults(MotionKind::camera);
  config.range_m = 3.0;
  test::TargetMotion motion;  // seen from the camera: it moves to the left and down and turns slowly
  motion.t_CB0 = Vec3(-0.4, 0.0, 3.4);
  motion.R_CB0 = exp_so3(Vec3(0.5, 0.6, 0.1));
  motion.v_C = Vec3(0.12, 0.03, 0.02);
  motion.omega_C = test::degree * Vec3(0.0, 0.5, 0.0);
  for (std::uint64_t seed = 1; seed <= camera_runs; ++seed) {
    test::FilterRun run(config, motion, 0.3, seed, 0.1);
    for (int k = 0; k < 100; ++k) {
      run.step();
      CHECK(run.last().status == Status::ok);
    }
    const RelativeState out = run.filter().output();
    const Vec3 t_true = run.simulation().t_CB() - run.R_CT_true() * motion.t_CB0;
    const double direction_deg = degrees(std::acos(out.t_CT.normalized().dot(t_true.normalized())));
    const double attitude_deg = degrees(run.attitude_error(out).norm());
    std::printf("  camera, seed %d: attitude %.2f deg, direction of travel %.1f deg, scale %.2f, inliers %d\n",
                static_cast<int>(seed), attitude_deg, direction_deg, out.t_CT.norm() / t_true.norm(),
                run.last().inliers);
    CHECK(attitude_deg < 2.0);
    CHECK(direction_deg < 10.0);
    CHECK(run.last().inliers >= 20);
  }
}

/// Two filters in the same state, which `run` has reached, one of them with another configuration.
struct Pair {
  std::unique_ptr<NoncoopFilter> as_is;
  std::unique_ptr<NoncoopFilter> changed;
  Pair(test::FilterRun& run, const NoncoopConfig& config)
      : as_is(std::make_unique<NoncoopFilter>(run.filter())), changed(std::make_unique<NoncoopFilter>(run.filter())) {
    CHECK(changed->configure(config, test::sample_camera()) == Status::ok);
  }
  void predict(FeaturePredictions& predictions) {
    const Time next = as_is->output().time + Duration{100'000'000};
    CHECK(as_is->predict(next) == Status::ok);
    CHECK(changed->predict(next) == Status::ok);
    as_is->predict_features(predictions);
  }
};

TEST(NoncoopFilters, features_walk_with_the_angle_turned) {
  NoncoopConfig config = near_target();
  test::FilterRun run(config, turning_at(Vec3(0.0, 3.0, 0.0)), 0.3, 5, 0.1);
  for (int k = 0; k < 80; ++k) run.step();
  config.feature_walk_px2_per_deg = 0.0;
  Pair pair(run, config);
  FeaturePredictions predictions;
  pair.predict(predictions);
  const double variance_px2 = near_target().feature_walk_px2_per_deg * 3.0 * 0.1;
  int compared = 0;
  for (const Feature& f : pair.as_is->state().features()) {
    if (f.size != 3) continue;
    const RelativeState out = pair.as_is->output();
    const double distance_m = (out.R_CT * f.y.head<3>() + out.t_CT).norm();
    const double expected = variance_px2 * (distance_m * distance_m) /
                            (test::sample_camera().intrinsics().fu * test::sample_camera().intrinsics().fu);
    for (int k = f.offset; k < f.offset + 3; ++k) {
      const double grown = pair.as_is->state().P_at(k, k) - pair.changed->state().P_at(k, k);
      DOUBLES_EQUAL(expected, grown, 0.05 * expected);
    }
    ++compared;
  }
  CHECK(compared > 10);
}

TEST(NoncoopFilters, a_match_that_deviates_counts_less) {
  NoncoopConfig config = near_target();
  test::FilterRun run(config, turning_at(Vec3(0.0, 2.0, 0.0)), 0.3, 6, 0.1);
  for (int k = 0; k < 80; ++k) run.step();
  config.robust_sigma = 0.0;
  Pair pair(run, config);
  FeaturePredictions predictions;
  pair.predict(predictions);
  const Vec3 before = pair.as_is->output().t_CT;
  FeatureMatches matches;
  FeatureMatch match;
  match.slot = predictions[0].slot;
  match.uv_px = predictions[0].uv_px + Vec2(1.5 * std::sqrt(predictions[0].S_px2(0, 0)), 0.0);
  match.sigma_px = 0.1;
  CHECK(matches.push_back(match) == Status::ok);
  LONGS_EQUAL(1, pair.as_is->update(matches).inliers);
  LONGS_EQUAL(1, pair.changed->update(matches).inliers);
  const double with = (pair.as_is->output().t_CT - before).norm();
  const double without = (pair.changed->output().t_CT - before).norm();
  std::printf("  robust: moved %.2e m, else %.2e m\n", with, without);
  CHECK(with > 0.0);
  CHECK(with < 0.8 * without);
}

TEST(NoncoopFilters, same_seed_same_bits) {
  const auto run = [] {
    auto r = std::make_unique<test::FilterRun>(near_target(), turning_at(Vec3(0.5, 2.0, 0.0)), 0.3, 9, 0.1);
    for (int k = 0; k < warm_up; ++k) r->step();
    return r->filter().output();
  };
  const RelativeState a = run();
  const RelativeState b = run();
  CHECK(a.t_CT == b.t_CT && a.R_CT == b.R_CT && a.pose_covariance == b.pose_covariance);
  CHECK(a.v_C == b.v_C && a.omega_C == b.omega_C && a.rate_covariance == b.rate_covariance);
}

TEST(NoncoopFilters, wild_matches_are_left_out) {
  test::FilterRun run(near_target(), turning_at(Vec3(0.0, 2.0, 0.5)), 0.3, 4, 0.1);
  for (int k = 0; k < warm_up; ++k) run.step();
  NoncoopFilter& filter = run.filter();
  run.simulation().advance(0.1);
  CHECK(filter.predict(filter.output().time + Duration{100'000'000}) == Status::ok);
  FeaturePredictions predictions;
  FeatureMatches matches;
  filter.predict_features(predictions);
  run.simulation().measure(predictions, matches);
  CHECK(matches.size() > 20);
  for (std::size_t i = 0; i < matches.size(); i += 5) matches[i].uv_px += Vec2(25.0, -25.0);
  matches[1].slot.generation = static_cast<std::uint16_t>(matches[1].slot.generation + 1);  // nobody's
  const FilterUpdate update = filter.update(matches);
  CHECK(update.status == Status::ok);
  for (std::size_t i = 0; i < matches.size(); i += 5) CHECK(update.verdict[i] <= MatchVerdict::outlier);
  CHECK(update.verdict[1] == MatchVerdict::incompatible);
  CHECK(update.inliers >= static_cast<int>(matches.size()) * 6 / 10);
  CHECK(degrees(run.attitude_error(filter.output()).norm()) < 2.0);
}

}  // namespace
}  // namespace relnav
