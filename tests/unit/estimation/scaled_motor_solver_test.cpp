// solve_scaled_motor: the motor solution in float and fixed point against double, over the paper's poses and from 1 to 200 m.
#include "fsw/estimation/scaled_motor_solver.hpp"

#include <cmath>
#include <cstdio>

#include "fsw/estimation/closed_form_covariance.hpp"
#include "tests/support/campaign.hpp"
#include "tests/support/dense.hpp"
#include "tests/unit/estimation/pose_samples.hpp"

#include <CppUTest/TestHarness.h>

namespace relnav {
namespace {

using test::degrees_per_radian;

constexpr int poses = test::campaign(10000, 200);

CameraRig rig_of(const CameraIntrinsics& camera, double baseline) {
  return test::stereo_rig(camera, camera, test::reference_dcm(Vec3::UnitY(), 0.01), Vec3(baseline, 0.0, 0.0));
}

struct Sweep {
  int failures = 0;
  int count = 0;
  double largest = 0.0;  ///< distance to double's over the sigma of 1 px
};

/// Adds what one epoch of 1 px says.
template <typename S>
void add(const CameraRig& rig, const TargetModel& target, const Pose& truth, MotorLines lines, test::Normal& rng,
         Sweep& sweep) {
  const PoseObservations seen = test::see_all(rig, target, truth, 1.0, rng);
  StereoPoints points;
  Pose expected;
  Pose actual;
  CHECK(triangulate_features(rig, target, seen, points) == Status::ok);
  const auto solve = [&](const StereoPoints& at, Pose& pose) { return solve_motor(target, at, lines, pose); };
  CHECK(solve(points, expected) == Status::ok);
  if (solve_scaled_motor<S>(rig, target, seen, lines, actual) != Status::ok) {
    ++sweep.failures;
    return;
  }
  if (sweep.count++ % 5 != 0) return;  // its covariance takes 32 solutions
  Mat6 covariance;
  CHECK(propagate_pixel_noise(rig, seen, points, solve, covariance) == Status::ok);
  const Vec6 d = test::pose_difference(actual, expected);
  sweep.largest = std::max(sweep.largest, std::sqrt(test::mahalanobis_squared(d, covariance)));
}

/// Pitch, yaw and roll from -40 to 40 deg at 4.2 m, then 3 to 10 m: stereo-pose of `relnav scenario`.
template <typename S>
Sweep over_the_papers_poses(MotorLines lines) {
  test::Normal rng(1);
  const CameraRig rig =
      test::stereo_rig(test::stereo_paper_camera(), test::stereo_paper_camera(), Mat3::Identity(), Vec3(1.0, 0.0, 0.0));
  const TargetModel target = test::target_of(test::square(0.5));
  Sweep sweep;
  for (int axis = 0; axis < 3; ++axis) {
    for (int angle_deg = -40; angle_deg <= 40; ++angle_deg) {
      const Mat3 R_CT = test::reference_dcm(Vec3::Unit(axis), angle_deg / degrees_per_radian);
      for (int i = 0; i < 10; ++i) add<S>(rig, target, {R_CT, Vec3(0.5, 0.0, 4.2)}, lines, rng, sweep);
    }
  }
  for (double range = 3.0; range <= 10.0; range += 0.01) {
    add<S>(rig, target, {Mat3::Identity(), Vec3(0.5, 0.0, range)}, lines, rng, sweep);
  }
  return sweep;
}

/// Attitudes evenly over SO(3), every fourth a turn by exactly 180 deg; ranges from 1 to 200 m, evenly by their logarithm.
template <typename S>
Sweep over_all_attitudes(const CameraIntrinsics& camera, bool flat, MotorLines lines, int count) {
  test::Normal rng(2);
  Sweep sweep;
  for (int i = 0; i < count; ++i) {
    const double range = std::pow(200.0, rng.generator().uniform());
    const double field = 1000.0 / camera.fu;
    const double baseline = std::min(2.0, 0.3 * field * range);
    const double radius = std::min(0.5, 0.2 * field * range);
    const TargetModel target = test::target_of(flat ? test::square(radius) : test::cube(radius / std::sqrt(3.0)));
    const Mat3 R_CT = i % 4 == 3 ? test::random_half_turn(rng) : test::random_attitude(rng);
    add<S>(rig_of(camera, baseline), target, {R_CT, Vec3(0.5 * baseline, 0.0, range)}, lines, rng, sweep);
  }
  return sweep;
}

}  // namespace

TEST_GROUP(ScaledMotorSolver){};

namespace {

TEST(ScaledMotorSolver, every_arithmetic_agrees_over_the_papers_poses) {
  for (const MotorLines lines : {MotorLines::target, MotorLines::all}) {
    const Sweep in_double = over_the_papers_poses<double>(lines);
    const Sweep in_float = over_the_papers_poses<float>(lines);
    const Sweep in_fixed = over_the_papers_poses<FixedQ47>(lines);
    std::printf("    %s lines, distance from double in sigma: scaled double %.1e, float %.1e, Q16.47 %.1e\n",
                lines == MotorLines::all ? "all" : "target's", in_double.largest, in_float.largest, in_fixed.largest);
    for (const Sweep& sweep : {in_double, in_float, in_fixed}) LONGS_EQUAL(0, sweep.failures);
    CHECK(in_double.largest < 1e-11);
    CHECK(in_float.largest < 2e-3);
    CHECK(in_fixed.largest < 1e-8);
  }
}

TEST(ScaledMotorSolver, no_overflow_from_1_to_200_m_at_any_attitude) {
  for (const CameraIntrinsics& camera : {test::stereo_paper_camera(), test::pinhole(), test::long_focus()}) {
    for (const bool flat : {true, false}) {
      const MotorLines lines = flat ? MotorLines::target : MotorLines::all;
      const Sweep fixed = over_all_attitudes<FixedQ47>(camera, flat, lines, flat ? poses : poses / 10);
      const Sweep single = over_all_attitudes<float>(camera, flat, lines, poses / 10);
      std::printf("    f = %.0f px, %s: Q16.47 %d failures, %.1e sigma; float %d, %.1e\n", camera.fu,
                  flat ? "square" : "cube", fixed.failures, fixed.largest, single.failures, single.largest);
      LONGS_EQUAL(0, fixed.failures);
      LONGS_EQUAL(0, single.failures);
      CHECK(fixed.largest < 1e-7);
      CHECK(single.largest < 1e-2);
    }
  }
}

TEST(ScaledMotorSolver, off_centre_and_without_noise_it_is_exact) {
  test::Normal rng(3);
  const CameraRig rig = rig_of(test::stereo_paper_camera(), 1.0);
  const Vec3 middle(1.0, -0.5, 2.0);
  const TargetModel target = test::target_of(test::square(0.5, middle));
  for (int i = 0; i < 100; ++i) {
    Pose truth{test::random_attitude(rng), Vec3(0.5, 0.1, 6.0)};
    truth.t_CT -= truth.R_CT * middle;
    const PoseObservations seen = test::see_all(rig, target, truth, 1.0, rng, 0.0);
    Pose pose;
    CHECK(solve_scaled_motor<FixedQ47>(rig, target, seen, MotorLines::target, pose) == Status::ok);
    CHECK(test::pose_difference(truth, pose).norm() < 1e-10);
  }
}

template <typename S>
void check_refusals() {
  test::Normal rng(4);
  const CameraRig rig = rig_of(test::stereo_paper_camera(), 1.0);
  const TargetModel target = test::target_of(test::square(0.5));
  const Pose truth{test::reference_dcm(Vec3(1.0, 0.5, 0.2), 0.4), Vec3(0.5, 0.0, 6.0)};
  const PoseObservations seen = test::see_all(rig, target, truth, 1.0, rng);
  Pose pose{Mat3::Zero(), Vec3::Zero()};
  const auto status_of = [&](const CameraRig& with, const TargetModel& of, const PoseObservations& observations) {
    return solve_scaled_motor<S>(with, of, observations, MotorLines::target, pose);
  };
  CHECK(status_of(test::mono_rig(test::stereo_paper_camera()), target, seen) == Status::invalid_argument);
  CHECK(status_of(rig_of(test::stereo_paper_camera(), 0.0), target, seen) == Status::rank_deficient);
  PoseObservations bad = seen;
  bad[5].feature = 4;
  CHECK(status_of(rig, target, bad) == Status::invalid_argument);
  bad.clear();
  CHECK(status_of(rig, target, bad) == Status::too_few_features);
  for (const std::size_t i : {0U, 1U, 4U, 5U}) CHECK(bad.push_back(seen[i]) == Status::ok);  // two in both cameras
  CHECK(status_of(rig, target, bad) == Status::too_few_features);
  bad = seen;
  for (const std::size_t i : {4U, 5U, 6U}) bad[i].uv_px += Vec2(2000.0, 0.0);  // behind the cameras
  CHECK(status_of(rig, target, bad) == Status::inconsistent);
  const TargetModel line = test::target_of({Vec3(0, 0, 0), Vec3(0.1, 0, 0), Vec3(0.3, 0, 0), Vec3(-0.2, 0, 0)});
  CHECK(status_of(rig, line, test::see_all(rig, line, truth, 1.0, rng, 0.0)) == Status::rank_deficient);
  const TargetModel point = test::target_of({Vec3::Zero(), Vec3::Zero(), Vec3::Zero()});
  CHECK(status_of(rig, point, test::see_all(rig, point, truth, 1.0, rng)) == Status::rank_deficient);
  CHECK(pose.R_CT == Mat3::Zero() && pose.t_CT == Vec3::Zero());  // untouched
}

TEST(ScaledMotorSolver, says_what_is_missing) {
  check_refusals<double>();
  check_refusals<float>();
  check_refusals<FixedQ47>();
}

TEST(ScaledMotorSolver, a_number_out_of_range_is_said) {
  // Lines of 0.1 mm seen from 5 km: their points are thousands of sizes apart, by the noise of their depth.
  test::Normal rng(5);
  const CameraRig rig = rig_of(test::stereo_paper_camera(), 5.0);
  const TargetModel target = test::target_of(test::square(1e-4));
  int said = 0;
  for (int i = 0; i < 50; ++i) {
    const Pose truth{Mat3::Identity(), Vec3(2.5, 0.0, 5000.0)};
    Pose pose;
    const Status status = solve_scaled_motor<FixedQ47>(rig, target, test::see_all(rig, target, truth, 1.0, rng),
                                                       MotorLines::target, pose);
    said += status == Status::not_finite ? 1 : 0;
  }
  LONGS_EQUAL(50, said);
}

}  // namespace
}  // namespace relnav
