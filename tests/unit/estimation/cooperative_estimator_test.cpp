// CooperativeEstimator: the maximum-likelihood pose from any start, both poses of a flat target, honest statuses.
#include "fsw/estimation/cooperative_estimator.hpp"

#include <cmath>
#include <memory>
#include <utility>

#include "tests/support/dense.hpp"
#include "tests/unit/estimation/pose_samples.hpp"

#include <CppUTest/TestHarness.h>

namespace relnav {
namespace {

using test::degrees_per_radian;
using test::reference_dcm;

constexpr double sigma_px = 0.3;

TargetModel uneven_target() {
  test::Normal layout(30);
  std::vector<Vec3> points = test::cube(0.5);
  for (Vec3& p : points) p += 0.12 * layout.vec3();
  return test::target_of(points);
}

CameraRig two_cameras(double extrinsics_error_deg = 0.0) {
  const Mat3 R_10 = reference_dcm(Vec3(0.1, 1.0, 0.0), 0.12);
  CameraRig rig = test::stereo_rig(test::pinhole(), test::distorted(DistortionModel::radial_tangential), R_10,
                                   Vec3(0.8, 0.05, -0.02));
  rig[1].R_KC = reference_dcm(Vec3::UnitY(), extrinsics_error_deg / degrees_per_radian) * rig[1].R_KC;
  return rig;
}

Pose some_pose(test::Normal& rng) {
  const double range = 4.0 + 3.0 * rng.generator().uniform();
  Pose pose;
  pose.R_CT = test::random_attitude(rng);
  pose.t_CT = range * rng.ahead(0.1);
  return pose;
}

CooperativeConfig config_of(CooperativeMethod method, MotorLines lines = MotorLines::target) {
  CooperativeConfig config;
  config.method = method;
  config.lines = lines;
  return config;
}

/// Distance of two poses in the sigmas of the estimate.
double sigmas_between(const PoseEstimate& estimate, const Pose& pose) {
  const Vec6 d = test::pose_difference(estimate.pose, pose);
  return std::sqrt(test::mahalanobis_squared(d, estimate.covariance));
}

}  // namespace

TEST_GROUP(CooperativeEstimator) {
  std::unique_ptr<CooperativeEstimator> estimator = std::make_unique<CooperativeEstimator>();
  CooperativeSolution out;

  void configure(const CameraRig& rig, const TargetModel& target, const CooperativeConfig& config = {}) {
    CHECK(estimator->configure(config, rig, target) == Status::ok);
  }
  /// Cold, warm, and with a prior half a turn off: the same optimum.
  void check_optimum(const CameraRig& rig, std::uint64_t seed) {
    const TargetModel target = uneven_target();
    configure(rig, target);
    test::Normal rng(seed);
    for (int k = 0; k < 60; ++k) {
      const Pose truth = some_pose(rng);
      const PoseObservations seen = test::see_all(rig, target, truth, sigma_px, rng);
      const Pose optimum = test::reference_optimum(rig, target, seen, truth);
      const double chi2 = test::residuals(rig, target, seen, optimum).squaredNorm();
      Pose near = truth;
      near.R_CT = reference_dcm(rng.vec3(), 0.1) * truth.R_CT;
      near.t_CT += 0.1 * rng.vec3();
      Pose bad = truth;
      bad.R_CT = test::random_half_turn(rng) * truth.R_CT;
      for (const Pose* prior :
           {static_cast<const Pose*>(nullptr), static_cast<const Pose*>(&near), static_cast<const Pose*>(&bad)}) {
        CHECK(estimator->solve(seen, prior, out) == Status::ok);
        CHECK(sigmas_between(out.estimate, optimum) < 1e-4);
        DOUBLES_EQUAL(chi2, out.estimate.chi2, 1e-6 * chi2);
        LONGS_EQUAL(static_cast<int>(seen.size()), out.estimate.used);
        LONGS_EQUAL(2 * static_cast<int>(seen.size()) - 6, out.estimate.degrees_of_freedom);
        for (std::size_t i = 0; i < seen.size(); ++i) CHECK(out.used[i]);
        CHECK(!out.used[seen.size()]);
        if (prior == nullptr) CHECK(out.acquired);
        if (prior == &near) CHECK(!out.acquired);
      }
    }
  }
};

TEST(CooperativeEstimator, one_camera_gives_the_optimum_from_any_prior) {
  check_optimum(test::mono_rig(test::distorted(DistortionModel::radial_tangential)), 1);
}

TEST(CooperativeEstimator, two_cameras_give_the_optimum_from_any_prior) { check_optimum(two_cameras(), 2); }

TEST(CooperativeEstimator, a_gross_error_is_left_out_and_shown) {
  test::Normal rng(3);
  for (const CameraRig& rig : {test::mono_rig(test::pinhole()), two_cameras()}) {
    const TargetModel target = uneven_target();
    configure(rig, target);
    for (int k = 0; k < 30; ++k) {
      const Pose truth = some_pose(rng);
      PoseObservations seen = test::see_all(rig, target, truth, sigma_px, rng);
      const std::size_t wrong = rng.generator().below(static_cast<std::uint32_t>(seen.size()));
      seen[wrong].uv_px += Vec2(-30.0, 25.0);
      CHECK(estimator->solve(seen, k % 2 == 0 ? &truth : nullptr, out) == Status::ok);
      for (std::size_t i = 0; i < seen.size(); ++i) CHECK(out.used[i] == (i != wrong));
      LONGS_EQUAL(static_cast<int>(seen.size()) - 1, out.estimate.used);
      CHECK(sigmas_between(out.estimate, truth) < 6.0);
    }
  }
}

/// A square far away, tilted: both minima, mirrored about the line of sight, explain it.
TEST(CooperativeEstimator, a_square_is_ambiguous_until_a_prior_decides) {
  const CameraRig rig = test::mono_rig(test::pinhole());
  const TargetModel target = test::target_of(test::square(0.5));
  configure(rig, target);
  test::Normal rng(4);
  for (int k = 0; k < 30; ++k) {
    Pose truth;
    truth.R_CT = reference_dcm(Vec3(std::cos(0.2 * k), std::sin(0.2 * k), 0.0), 0.6) *
                 reference_dcm(Vec3::UnitX(), 3.14159265358979);
    truth.t_CT = Vec3(0.3, -0.2, 20.0);
    const PoseObservations seen = test::see_all(rig, target, truth, sigma_px, rng);
    CHECK(estimator->solve(seen, nullptr, out) == Status::ambiguous);
    const double first = test::rotation_angle(out.estimate.pose.R_CT, truth.R_CT);
    const double second = test::rotation_angle(out.other.pose.R_CT, truth.R_CT);
    CHECK(std::min(first, second) < 0.15);
    CHECK(std::max(first, second) > 0.8);
    CHECK(out.estimate.chi2 <= out.other.chi2);
    const Pose right = first < second ? out.estimate.pose : out.other.pose;
    const Pose mirrored = first < second ? out.other.pose : out.estimate.pose;

    // Each of the two is chosen by a prior near to it, be its chi-square what it may.
    for (const Pose& chosen : {right, mirrored}) {
      Pose prior = chosen;
      prior.R_CT = reference_dcm(rng.vec3(), 0.05) * prior.R_CT;
      CHECK(estimator->solve(seen, &prior, out) == Status::ok);
      CHECK(test::rotation_angle(out.estimate.pose.R_CT, chosen.R_CT) < 1e-3);
    }
    // A prior that is near to neither decides nothing.
    Pose bad = truth;
    bad.R_CT = truth.R_CT * reference_dcm(Vec3::UnitZ(), 1.6);
    CHECK(estimator->solve(seen, &bad, out) == Status::ambiguous);
    bad.R_CT = truth.R_CT * reference_dcm(Vec3::UnitZ(), 3.14159265358979);
    CHECK(estimator->solve(seen, &bad, out) == Status::ambiguous);
  }
}

/// Nearly flat and near: the mirrored pose is a minimum still, but one that does not fit.
TEST(CooperativeEstimator, a_prior_in_a_wrong_minimum_does_not_hold_it) {
  const CameraRig rig = test::mono_rig(test::pinhole());
  std::vector<Vec3> points = test::square(0.5);
  for (const Vec3& p : test::square(0.3)) points.push_back(reference_dcm(Vec3::UnitZ(), 0.5) * p);
  points[1].z() = points[6].z() = 0.06;
  points[4].z() = -0.04;
  const TargetModel target = test::target_of(points);
  configure(rig, target);
  test::Normal rng(9);
  int trapped = 0;
  for (int k = 0; k < 30; ++k) {
    Pose truth;
    truth.R_CT = reference_dcm(Vec3(std::cos(0.2 * k), std::sin(0.2 * k), 0.0), 0.6);
    truth.t_CT = Vec3(0.3, -0.2, 8.0);
    const PoseObservations seen = test::see_all(rig, target, truth, sigma_px, rng);
    Pose prior = truth;
    prior.R_CT = reference_dcm(Vec3(std::cos(0.2 * k), std::sin(0.2 * k), 0.0), -0.6);
    PoseEstimate from_prior;
    if (solve_pose(rig, target, seen, test::all_used(), prior, {}, from_prior) == Status::ok &&
        is_alarming(from_prior, {})) {
      ++trapped;
    }
    CHECK(estimator->solve(seen, &prior, out) == Status::ok);
    CHECK(sigmas_between(out.estimate, test::reference_optimum(rig, target, seen, truth)) < 1e-4);
    LONGS_EQUAL(8, out.estimate.used);
    CHECK(out.acquired);
  }
  CHECK(trapped > 20);
}

TEST(CooperativeEstimator, a_square_before_two_cameras_is_not_ambiguous) {
  const CameraRig rig = two_cameras();
  const TargetModel target = test::target_of(test::square(0.5));
  configure(rig, target);
  test::Normal rng(5);
  for (int k = 0; k < 30; ++k) {
    Pose truth = some_pose(rng);
    truth.R_CT = reference_dcm(rng.vec3(), 0.5);
    const PoseObservations seen = test::see_all(rig, target, truth, sigma_px, rng);
    CHECK(estimator->solve(seen, nullptr, out) == Status::ok);
    CHECK(sigmas_between(out.estimate, truth) < 6.0);
  }
}

TEST(CooperativeEstimator, swapped_cameras_are_not_believed) {
  const CameraRig rig = two_cameras();
  const TargetModel target = uneven_target();
  configure(rig, target);
  test::Normal rng(6);
  for (int k = 0; k < 5; ++k) {
    const Pose truth = some_pose(rng);
    PoseObservations seen = test::see_all(rig, target, truth, sigma_px, rng);
    for (std::size_t i = 0; i < seen.size(); ++i) seen[i].camera = static_cast<std::uint16_t>(1 - seen[i].camera);
    CHECK(estimator->solve(seen, k % 2 == 0 ? &truth : nullptr, out) == Status::inconsistent);
  }
}

/// Parallel cameras swapped: the rays meet behind them, nothing can be solved.
TEST(CooperativeEstimator, swapped_parallel_cameras_are_inconsistent_by_every_method) {
  const CameraRig rig = test::stereo_rig(test::pinhole(), test::pinhole(), Mat3::Identity(), Vec3(1.0, 0.0, 0.0));
  const TargetModel target = test::target_of(test::square(0.5));
  test::Normal rng(16);
  for (const CooperativeMethod method :
       {CooperativeMethod::least_squares, CooperativeMethod::motor, CooperativeMethod::orthogonal}) {
    configure(rig, target, config_of(method));
    for (int k = 0; k < 10; ++k) {
      const Pose truth{reference_dcm(rng.vec3(), 0.06 * k), Vec3(0.5, 0.0, 4.0)};
      PoseObservations seen = test::see_all(rig, target, truth, sigma_px, rng);
      CHECK(estimator->solve(seen, nullptr, out) == Status::ok);
      for (std::size_t i = 0; i < seen.size(); ++i) seen[i].camera = static_cast<std::uint16_t>(1 - seen[i].camera);
      CHECK(estimator->solve(seen, nullptr, out) == Status::inconsistent);
    }
  }
}

TEST(CooperativeEstimator, closed_forms_do_not_believe_a_camera_turned_by_two_degrees) {
  CameraRig rig = two_cameras();
  const TargetModel target = test::target_of(test::square(0.5));
  test::Normal rng(17);
  for (const CooperativeMethod method : {CooperativeMethod::motor, CooperativeMethod::orthogonal}) {
    for (int k = 0; k < 10; ++k) {
      Pose truth = some_pose(rng);
      truth.R_CT = reference_dcm(rng.vec3(), 0.5);
      const PoseObservations seen = test::see_all(two_cameras(), target, truth, sigma_px, rng);
      configure(rig, target, config_of(method));
      CHECK(estimator->solve(seen, nullptr, out) == Status::ok);
      CameraRig bad = rig;
      bad[1].R_KC = reference_dcm(Vec3::UnitX(), (k % 2 == 0 ? 2.0 : -2.0) / degrees_per_radian) * bad[1].R_KC;
      configure(bad, target, config_of(method));
      CHECK(estimator->solve(seen, nullptr, out) == Status::inconsistent);
    }
  }
}

TEST(CooperativeEstimator, a_camera_turned_by_five_degrees_is_not_believed) {
  const CameraRig rig = two_cameras();
  const TargetModel target = uneven_target();
  test::Normal rng(7);
  for (int k = 0; k < 5; ++k) {
    configure(two_cameras(k % 2 == 0 ? 5.0 : -5.0), target);
    const Pose truth = some_pose(rng);
    const PoseObservations seen = test::see_all(rig, target, truth, sigma_px, rng);
    CHECK(estimator->solve(seen, k % 2 == 0 ? &truth : nullptr, out) == Status::inconsistent);
  }
}

TEST(CooperativeEstimator, closed_forms_give_their_own_pose_with_its_chi_square) {
  const CameraRig rig = two_cameras();
  const TargetModel target = test::target_of(test::square(0.5));
  test::Normal rng(8);
  for (int k = 0; k < 20; ++k) {
    Pose truth = some_pose(rng);
    truth.R_CT = reference_dcm(rng.vec3(), 0.5);
    const PoseObservations seen = test::see_all(rig, target, truth, sigma_px, rng);
    StereoPoints points;
    CHECK(triangulate_features(rig, target, seen, points) == Status::ok);
    for (const MotorLines lines : {MotorLines::target, MotorLines::all}) {
      Pose expected;
      CHECK(solve_motor(target, points, lines, expected) == Status::ok);
      configure(rig, target, config_of(CooperativeMethod::motor, lines));
      CHECK(estimator->solve(seen, nullptr, out) == Status::ok);
      CHECK((out.estimate.pose.R_CT - expected.R_CT).norm() < 1e-12);
      CHECK((out.estimate.pose.t_CT - expected.t_CT).norm() < 1e-12);
      const double chi2 = test::residuals(rig, target, seen, expected).squaredNorm();
      DOUBLES_EQUAL(chi2, out.estimate.chi2, 1e-6 * chi2);
    }
    Pose expected;
    CHECK(solve_orthogonal(points, expected) == Status::ok);
    configure(rig, target, config_of(CooperativeMethod::orthogonal));
    CHECK(estimator->solve(seen, &truth, out) == Status::ok);
    CHECK((out.estimate.pose.R_CT - expected.R_CT).norm() < 1e-12);
    CHECK((out.estimate.pose.t_CT - expected.t_CT).norm() < 1e-12);
    LONGS_EQUAL(8, out.estimate.used);
  }
}

TEST(CooperativeEstimator, refuses_what_it_cannot_do) {
  const CameraRig one = test::mono_rig(test::pinhole());
  const TargetModel target = uneven_target();
  const std::vector<Vec3> two_points = {Vec3::Zero(), Vec3::UnitX()};
  CHECK(estimator->configure({}, CameraRig(), target) == Status::invalid_argument);
  CHECK(estimator->configure({}, one, test::target_of(two_points)) == Status::invalid_argument);
  for (const CooperativeMethod method : {CooperativeMethod::motor, CooperativeMethod::orthogonal}) {
    CHECK(estimator->configure(config_of(method), one, target) == Status::invalid_argument);
    CHECK(estimator->configure(config_of(method), two_cameras(), target) == Status::ok);
  }
  CHECK(estimator->configure({}, one, target) == Status::ok);
  PoseObservations none;
  CHECK(estimator->solve(none, nullptr, out) == Status::too_few_features);
}

}  // namespace relnav
