// PoseFilter: velocity and rate from poses, honest covariances, a gate that holds, no attitude it cannot pass.
#include "fsw/estimation/pose_filter.hpp"

#include <algorithm>
#include <cmath>

#include "fsw/attitude/so3.hpp"
#include "tests/support/dense.hpp"
#include "tests/support/normal.hpp"
#include "tests/unit/estimation/spot_simulation.hpp"

#include <CppUTest/TestHarness.h>

namespace relnav {
namespace {

constexpr double step_s = 0.1;

Time time_of(int k) { return Time{static_cast<std::int64_t>(k) * 100'000'000}; }

double angle_between(const Mat3& a, const Mat3& b) { return log_so3(a * b.transpose()).norm(); }

/// Constant velocity and rate, measured with noise of a known covariance.
class Motion {
 public:
  explicit Motion(std::uint64_t seed) : rng_(seed) {
    pose_.R_CT = exp_so3(Vec3(rng_.vec3()));
    pose_.t_CT.z() = 8.0 + 0.5 * rng_();
    pose_.t_CT.head<2>() = 0.2 * rng_.vec2();
    v_C = 0.2 * rng_.vec3();
    omega_C = 0.1 * rng_.vec3();
    Mat6 root = Mat6::Zero();
    for (int r = 0; r < 6; ++r) {
      const double size = r < 3 ? 0.01 : 0.005;
      for (int c = 0; c < r; ++c) root(r, c) = 0.3 * size * rng_();
      root(r, r) = size;
    }
    root_ = root;
  }
  void advance() {
    pose_.t_CT += step_s * v_C;
    pose_.R_CT = exp_so3(Vec3(step_s * omega_C)) * pose_.R_CT;
  }
  PoseEstimate measure(double noise_factor = 1.0) {
    PoseEstimate out;
    out.covariance = root_ * root_.transpose();
    Vec6 n;
    for (int k = 0; k < 6; ++k) n(k) = noise_factor * rng_();
    const Vec6 d = root_ * n;
    // R_true = Exp([dphi x]) R_measured.
    out.pose.t_CT = pose_.t_CT - d.head<3>();
    out.pose.R_CT = exp_so3(Vec3(-d.tail<3>())) * pose_.R_CT;
    return out;
  }
  [[nodiscard]] const Pose& truth() const { return pose_; }

  Vec3 v_C;
  Vec3 omega_C;

 private:
  test::Normal rng_;
  Pose pose_;
  Mat6 root_;
};

PoseFilterConfig quiet() {
  PoseFilterConfig config;
  config.noise = {1e-4, 1e-4};  // the target does move with constant rates
  return config;
}

double quadratic(const Vec6& d, const Mat6& P) { return test::mahalanobis_squared(d, P); }

}  // namespace

TEST_GROUP(PoseFilter) {
  PoseFilter filter;

  void fly(Motion & motion, int frames, const PoseFilterConfig& config) {
    filter.configure(config);
    filter.start(time_of(0), motion.measure());
    for (int k = 1; k <= frames; ++k) {
      motion.advance();
      CHECK(filter.predict(time_of(k)) == Status::ok);
      CHECK(filter.update(motion.measure()) == Status::ok);
    }
  }
};

namespace {

TEST(PoseFilter, starts_at_the_measured_pose_with_its_covariance) {
  Motion motion(1);
  const PoseEstimate measured = motion.measure();
  filter.configure({});
  filter.start(time_of(3), measured);
  const RelativeState out = filter.output();
  CHECK(out.time == time_of(3));
  CHECK((out.t_CT - measured.pose.t_CT).norm() < 1e-12);
  CHECK(angle_between(out.R_CT, measured.pose.R_CT) < 1e-12);
  CHECK((out.pose_covariance - measured.covariance).norm() < 1e-9 * measured.covariance.norm());
  DOUBLES_EQUAL(0.0, out.v_C.norm() + out.omega_C.norm(), 0.0);
  DOUBLES_EQUAL(0.25, out.rate_covariance(0, 0), 1e-12);
  DOUBLES_EQUAL(0.04, out.rate_covariance(5, 5), 1e-12);
}

TEST(PoseFilter, finds_velocity_and_rate) {
  Motion motion(2);
  fly(motion, 100, quiet());
  const RelativeState out = filter.output();
  CHECK(out.time == time_of(100));
  CHECK((out.v_C - motion.v_C).norm() < 2e-3);  // 0.01 m, 10 s, 100 poses: 4e-4 an axis
  CHECK((out.omega_C - motion.omega_C).norm() < 1e-3);
  CHECK((out.t_CT - motion.truth().t_CT).norm() < 0.02);
  CHECK(angle_between(out.R_CT, motion.truth().R_CT) < 0.01);
  // Where it will be 2 s on.
  for (int k = 0; k < 20; ++k) motion.advance();
  CHECK(filter.predict(time_of(120)) == Status::ok);
  CHECK((filter.pose().t_CT - motion.truth().t_CT).norm() < 0.02);
  CHECK(angle_between(filter.pose().R_CT, motion.truth().R_CT) < 0.01);
}

TEST(PoseFilter, errors_are_as_large_as_the_covariances_say) {
  constexpr int seeds = 200;
  double rates = 0.0;
  double poses = 0.0;
  double nis = 0.0;
  for (int seed = 0; seed < seeds; ++seed) {
    Motion motion(100 + static_cast<std::uint64_t>(seed));
    fly(motion, 20, quiet());
    const RelativeState out = filter.output();
    Vec6 d;
    d << motion.v_C - out.v_C, motion.omega_C - out.omega_C;
    rates += quadratic(d, out.rate_covariance) / seeds;
    d << motion.truth().t_CT - out.t_CT, log_so3(motion.truth().R_CT * out.R_CT.transpose());
    poses += quadratic(d, out.pose_covariance) / seeds;
    nis += filter.nis() / seeds;
  }
  // Mean of 200 chi-squares of 6: 6 +- 0.245; four sigmas.
  DOUBLES_EQUAL(6.0, rates, 0.98);
  DOUBLES_EQUAL(6.0, poses, 0.98);
  DOUBLES_EQUAL(6.0, nis, 0.98);
}

TEST(PoseFilter, process_noise_adds_to_what_is_predicted) {
  Motion motion(4);
  filter.configure({});
  filter.start(time_of(0), motion.measure());
  const Mat6 before = filter.output().rate_covariance;
  CHECK(filter.predict(time_of(20)) == Status::ok);  // 2 s
  const Mat6 added = filter.output().rate_covariance - before;
  DOUBLES_EQUAL(0.05 * 0.05 * 2.0, added(0, 0), 1e-9);
  DOUBLES_EQUAL(0.1 * 0.1 * 2.0, added(3, 3), 1e-9);
  // 2 s of 0.5 m/s, and of white noise q^2 t^3 / 3.
  const double expected = 1.0 + 0.05 * 0.05 * 8.0 / 3.0 + motion.measure().covariance(0, 0);
  DOUBLES_EQUAL(expected, filter.pose_covariance()(0, 0), 1e-6);
}

TEST(PoseFilter, says_why_it_does_nothing) {
  Motion motion(5);
  filter.configure({});
  CHECK(!filter.has_started());
  CHECK(filter.predict(time_of(1)) == Status::not_configured);
  filter.start(time_of(1), motion.measure());
  CHECK(filter.has_started());
  CHECK(filter.predict(time_of(1)) == Status::out_of_order);
  CHECK(filter.predict(time_of(0)) == Status::out_of_order);
  CHECK(filter.output().time == time_of(1));
  CHECK(filter.predict(time_of(2)) == Status::ok);
  filter.restart();
  CHECK(!filter.has_started());
  CHECK(filter.predict(time_of(3)) == Status::not_configured);
}

TEST(PoseFilter, a_pose_outside_the_gate_changes_nothing) {
  Motion motion(6);
  fly(motion, 20, {});
  motion.advance();
  CHECK(filter.predict(time_of(21)) == Status::ok);
  const RelativeState before = filter.output();
  for (const bool turned : {false, true}) {
    PoseEstimate wrong = motion.measure();
    if (turned) {
      wrong.pose.R_CT = exp_so3(Vec3(0.0, 1.0, 0.0)) * wrong.pose.R_CT;
    } else {
      wrong.pose.t_CT.x() += 1.0;
    }
    CHECK(filter.update(wrong) == Status::inconsistent);
    CHECK(filter.nis() > 35.9);
    const RelativeState after = filter.output();
    CHECK(after.t_CT == before.t_CT);
    CHECK(after.R_CT == before.R_CT);
    CHECK(after.v_C == before.v_C);
    CHECK(after.omega_C == before.omega_C);
    CHECK(after.pose_covariance == before.pose_covariance);
    CHECK(after.rate_covariance == before.rate_covariance);
  }
  CHECK(filter.update(motion.measure()) == Status::ok);
  PoseEstimate nonsense = motion.measure();
  nonsense.pose.t_CT.x() = std::nan("");
  CHECK(filter.update(nonsense) == Status::inconsistent);
  nonsense = motion.measure();
  nonsense.covariance = -1e6 * Mat6::Identity();
  CHECK(filter.update(nonsense) == Status::not_positive_definite);
  CHECK(std::isfinite(filter.output().t_CT.norm()));
}

TEST(PoseFilter, turns_through_every_attitude) {
  Motion motion(7);
  motion.omega_C = Vec3(0.3, 0.8, -0.5);  // 1 rad/s: eight turns
  motion.v_C = Vec3::Zero();
  PoseFilterConfig config = quiet();
  config.rate_sigma_rad_s = 1.0;
  filter.configure(config);
  filter.start(time_of(0), motion.measure());
  const Mat3 R_0 = motion.truth().R_CT;
  double furthest = 0.0;
  double most_nees = 0.0;
  for (int k = 1; k <= 500; ++k) {
    motion.advance();
    CHECK(filter.predict(time_of(k)) == Status::ok);
    CHECK(filter.update(motion.measure()) == Status::ok);
    furthest = std::max(furthest, angle_between(motion.truth().R_CT, R_0));
    const RelativeState out = filter.output();
    Vec6 d;
    d << motion.truth().t_CT - out.t_CT, log_so3(motion.truth().R_CT * out.R_CT.transpose());
    most_nees = std::max(most_nees, quadratic(d, out.pose_covariance));
  }
  CHECK(furthest > 3.1);
  CHECK(most_nees < 40.0);
  CHECK((filter.output().omega_C - motion.omega_C).norm() < 1e-3);
}

/// Images of the first `count` markers of eight_leds() at a pose, with noise.
PoseObservations images_at(const Pose& pose, const TargetModel& target, std::size_t count, double sigma_px,
                           test::Normal& rng) {
  PoseObservations out;
  for (std::uint16_t k = 0; k < count; ++k) {
    PoseObservation o;
    o.feature = k;
    o.sigma_px = sigma_px;
    const Vec3 p_C = pose.R_CT * target.features[k].p_T + pose.t_CT;
    CHECK(test::one_camera()[0].model.project(p_C, o.uv_px) == Status::ok);
    o.uv_px += sigma_px * rng.vec2();
    CHECK(out.push_back(o) == Status::ok);
  }
  return out;
}

TEST(PoseFilter, two_markers_hold_the_pose_that_none_would_lose) {
  const CameraRig rig = test::one_camera();
  const TargetModel target = test::eight_leds();
  double nees = 0.0;
  constexpr int runs = 40;
  for (int r = 0; r < runs; ++r) {
    Motion motion(static_cast<std::uint64_t>(r + 1));
    test::Normal rng(static_cast<std::uint64_t>(r + 1));
    fly(motion, 10, quiet());
    PoseFilter alone = filter;
    ObservationMask used{};
    for (int k = 11; k <= 40; ++k) {
      motion.advance();
      CHECK(filter.predict(time_of(k)) == Status::ok);
      CHECK(alone.predict(time_of(k)) == Status::ok);
      CHECK(filter.update(rig, target, images_at(motion.truth(), target, 2, 0.1, rng), used) == Status::ok);
      CHECK(used[0] || used[1]);
      CHECK(!used[2]);
    }
    const Mat6 P = filter.pose_covariance();
    CHECK(P.trace() < 0.3 * alone.pose_covariance().trace());
    Vec6 d;
    d << motion.truth().t_CT - filter.pose().t_CT, log_so3(motion.truth().R_CT * filter.pose().R_CT.transpose());
    nees += quadratic(d, P) / runs;
  }
  // 6 degrees of freedom, 40 runs: 4.97 to 7.12 holds 95 %.
  CHECK(nees > 4.5);
  CHECK(nees < 7.8);
}

TEST(PoseFilter, an_image_off_its_place_is_not_used) {
  const CameraRig rig = test::one_camera();
  const TargetModel target = test::eight_leds();
  Motion motion(5);
  test::Normal rng(5);
  fly(motion, 10, quiet());
  motion.advance();
  CHECK(filter.predict(time_of(11)) == Status::ok);
  PoseObservations images = images_at(motion.truth(), target, 3, 0.1, rng);
  images[0].uv_px += Vec2(0.0, 40.0);
  ObservationMask used{};
  CHECK(filter.update(rig, target, images, used) == Status::ok);
  CHECK(!used[0]);
  CHECK(used[1]);
  CHECK(used[2]);

  const Pose before = filter.pose();
  images[1].uv_px += Vec2(40.0, 0.0);
  images[2].uv_px -= Vec2(0.0, 40.0);
  CHECK(filter.update(rig, target, images, used) == Status::inconsistent);
  CHECK(!used[0] && !used[1] && !used[2]);
  CHECK((filter.pose().t_CT - before.t_CT).norm() == 0.0);
  CHECK(filter.update(rig, target, PoseObservations(), used) == Status::inconsistent);
}

}  // namespace
}  // namespace relnav
