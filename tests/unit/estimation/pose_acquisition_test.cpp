// acquire_pose(): every attitude without a prior, ambiguity said, degenerate layouts refused.
#include "fsw/estimation/pose_acquisition.hpp"

#include <cmath>
#include <cstdio>

#include "tests/support/campaign.hpp"
#include "tests/support/dense.hpp"
#include "tests/unit/estimation/pose_samples.hpp"

#include <CppUTest/TestHarness.h>

namespace relnav {
namespace {

using test::degrees_per_radian;

constexpr int poses = test::campaign(10000, 500);

/// cooperative-mono.md: attitude wrong by more than 5 deg and more than 5 sigma of that view's own bound.
bool is_failure(const Pose& truth, const Pose& estimate, const Mat6& bound) {
  const Vec3 dphi = test::pose_difference(truth, estimate).tail<3>();
  const Mat3 P = bound.block<3, 3>(3, 3);
  return dphi.norm() * degrees_per_radian > 5.0 && test::mahalanobis_squared(dphi, P) > 25.0;
}

struct Report {
  int views = 0;
  int failures = 0;    ///< neither best nor other
  int best_wrong = 0;  ///< of these, `other` is right unless it is a failure
  int not_linear = 0;  ///< best is where the maximum-likelihood solution from the truth itself goes: no failure
  int ambiguous = 0;
  int most_iterations = 0;
};

/// Nearly face on, a plane's two minima merge and its error is no longer what the bound, a linear notion, says.
bool is_minimum_next_to_truth(const CameraRig& rig, const TargetModel& target, const PoseObservations& seen,
                              const Pose& truth, const Pose& estimate) {
  PoseEstimate e;
  return solve_pose(rig, target, seen, test::all_used(), truth, {}, e) == Status::ok &&
         test::rotation_angle(e.pose.R_CT, estimate.R_CT) * degrees_per_radian < 0.6;
}

/// Every fourth attitude exactly half a turn. `seen_of` adds the observations of a pose.
template <typename SeenOf>
Report acquire_many(const CameraRig& rig, const TargetModel& target, std::uint64_t seed, double least_range,
                    double range_span, const SeenOf& seen_of) {
  test::Normal rng(seed);
  Report report;
  for (int i = 0; i < poses; ++i) {
    Pose truth;
    truth.R_CT = i % 4 == 3 ? test::random_half_turn(rng) : test::random_attitude(rng);
    const double range = least_range + range_span * rng.generator().uniform();
    const double width = 0.3 * 1024.0 / rig[0].model.intrinsics().fu;
    truth.t_CT = range * rng.ahead(width);
    const PoseObservations seen = seen_of(truth, rng);
    if (seen.size() < 4) continue;
    ++report.views;
    const Mat6 bound = test::pose_bound(rig, target, seen, truth);
    AcquiredPose a;
    if (acquire_pose(rig, target, seen, test::all_used(), {}, a) != Status::ok) {
      ++report.failures;
      continue;
    }
    report.ambiguous += a.ambiguous ? 1 : 0;
    report.most_iterations = std::max(report.most_iterations, a.best.iterations);
    if (!is_failure(truth, a.best.pose, bound)) continue;
    if (is_minimum_next_to_truth(rig, target, seen, truth, a.best.pose)) {
      ++report.not_linear;
      continue;
    }
    ++report.best_wrong;
    if (!a.ambiguous || is_failure(truth, a.other.pose, bound)) ++report.failures;
  }
  return report;
}

void print(const char* name, const Report& r) {
  std::printf("    %s: %d views, %d failures, best wrong in %d, not linear %d, ambiguous %d, at most %d iterations\n",
              name, r.views, r.failures, r.best_wrong, r.not_linear, r.ambiguous, r.most_iterations);
}

/// The corners of the cube's faces that are turned to the camera.
PoseObservations visible_corners(const CameraRig& rig, const TargetModel& cube, const Pose& pose, double half_width,
                                 double sigma_px, test::Normal& rng) {
  const Vec3 eye_T = -(pose.R_CT.transpose() * pose.t_CT);
  PoseObservations seen;
  for (std::size_t f = 0; f < cube.features.size(); ++f) {
    bool visible = false;
    for (int k = 0; k < 3; ++k) visible = visible || cube.features[f].p_T(k) * eye_T(k) > half_width * half_width;
    if (visible && !test::see(rig, cube, pose, 0, f, sigma_px, rng, seen)) std::abort();
  }
  return seen;
}

}  // namespace

TEST_GROUP(PoseAcquisition){};

TEST(PoseAcquisition, no_failure_on_eight_points_at_any_attitude) {
  const CameraRig rig = test::mono_rig(test::long_focus());
  const TargetModel target = test::target_of(test::cube(1.0));
  const Report r = acquire_many(rig, target, 1, 99.0, 2.5, [&](const Pose& truth, test::Normal& rng) {
    return test::see_all(rig, target, truth, 1.0, rng);
  });
  print("8 points, 100 m", r);
  LONGS_EQUAL(poses, r.views);
  LONGS_EQUAL(0, r.failures);
  LONGS_EQUAL(0, r.best_wrong + r.not_linear);
}

TEST(PoseAcquisition, no_failure_on_the_visible_corners_of_a_cube) {
  const CameraRig rig = test::mono_rig(test::long_focus());
  const TargetModel target = test::target_of(test::cube(1.0));
  const Report r = acquire_many(rig, target, 2, 99.0, 2.5, [&](const Pose& truth, test::Normal& rng) {
    return visible_corners(rig, target, truth, 1.0, 1.0, rng);
  });
  print("visible corners, 100 m", r);
  LONGS_EQUAL(poses, r.views);
  LONGS_EQUAL(0, r.failures);
}

TEST(PoseAcquisition, no_failure_close_up_with_strong_perspective) {
  const CameraRig rig = test::mono_rig(test::distorted(DistortionModel::radial_tangential));
  test::Normal layout(30);
  std::vector<Vec3> points = test::cube(0.3);
  for (Vec3& p : points) p += 0.15 * layout.vec3() + Vec3(0.2, -0.1, 0.3);  // uneven, origin off-centre
  const TargetModel target = test::target_of(points);
  const Report r = acquire_many(rig, target, 3, 2.0, 3.0, [&](const Pose& truth, test::Normal& rng) {
    return test::see_all(rig, target, truth, 0.5, rng);
  });
  print("8 uneven points, 2 to 5 m", r);
  LONGS_EQUAL(0, r.failures);
  LONGS_EQUAL(0, r.best_wrong);
}

TEST(PoseAcquisition, a_planar_target_is_right_or_said_to_be_ambiguous) {
  const CameraRig rig = test::mono_rig(test::pinhole());
  const TargetModel target = test::target_of(test::square(0.5));
  const auto facing = [&](const Pose& truth, test::Normal& rng) {
    // Only views of 10 deg and more above the plane.
    const Vec3 eye = truth.R_CT.transpose() * truth.t_CT;
    if (std::fabs(eye.z()) < 0.17 * eye.norm()) return PoseObservations();
    return test::see_all(rig, target, truth, 0.5, rng);
  };
  for (const double range : {4.0, 10.0, 20.0}) {
    const Report r = acquire_many(rig, target, 4, range, 0.5 * range, facing);
    char name[40];
    std::snprintf(name, sizeof(name), "square, %.0f to %.0f m", range, 1.5 * range);
    print(name, r);
    // Where best is wrong, ambiguous is set and other is right.
    LONGS_EQUAL(0, r.failures);
    CHECK(r.most_iterations <= 20);
    if (range > 5.0) CHECK(r.best_wrong > 0);
  }
}

TEST(PoseAcquisition, where_two_minima_merge_both_starts_still_come_to_an_optimum) {
  const TargetModel target = test::target_of(test::square(0.5));
  for (const DistortionModel model : {DistortionModel::none, DistortionModel::equidistant}) {
    const CameraRig rig = test::mono_rig(test::distorted(model));
    test::Normal rng(9);
    double worst_sigma = 0.0;
    int most_iterations = 0;
    int slow = 0;
    for (int i = 0; i < 2000; ++i) {
      // Within 6 deg of face on.
      Vec3 axis = Vec3::Zero();
      axis.head<2>() = rng.vec2();
      const Mat3 roll = test::reference_dcm(Vec3::UnitZ(), 6.28 * rng.generator().uniform());
      const Pose truth{test::reference_dcm(axis, 0.1 * rng.generator().uniform()) * roll,
                       (10.0 + 5.0 * rng.generator().uniform()) * Vec3(0.1, -0.05, 1.0)};
      const PoseObservations seen = test::see_all(rig, target, truth, 0.5, rng);
      std::array<Pose, 2> starts;
      CHECK(orthographic_starts(rig, target, seen, test::all_used(), 0, starts) == Status::ok);
      for (const Pose& start : starts) {
        PoseEstimate e;
        CHECK(solve_pose(rig, target, seen, test::all_used(), start, {}, e) == Status::ok);
        most_iterations = std::max(most_iterations, e.iterations);
        if (e.iterations > 10) ++slow;
        if (i % 10 != 0) continue;
        const Pose optimum = test::reference_optimum(rig, target, seen, e.pose);
        const Eigen::MatrixXd J = test::pose_jacobian(rig, target, seen, e.pose);
        worst_sigma = std::max(worst_sigma, (J * test::pose_difference(optimum, e.pose)).norm());
      }
    }
    std::printf("    face on: %d of 4000 starts take more than 10 iterations, at most %d; optimum %.1e sigma away\n",
                slow, most_iterations, worst_sigma);
    CHECK(most_iterations <= 26);
    CHECK(slow > 10);  // the views are what they are meant to be
    CHECK(worst_sigma < 1e-6);
  }
}

TEST(PoseAcquisition, two_cameras_are_both_used) {
  test::Normal rng(5);
  const Mat3 R_10 = test::reference_dcm(Vec3(0.1, 1.0, 2.0), 0.25);
  const CameraRig rig =
      test::stereo_rig(test::pinhole(), test::distorted(DistortionModel::radial_inverse), R_10, Vec3(0.5, 0.1, -0.1));
  const TargetModel target = test::target_of(test::cube(0.3));
  int wrong = 0;
  for (int i = 0; i < 500; ++i) {
    const Pose truth{i % 4 == 3 ? test::random_half_turn(rng) : test::random_attitude(rng), Vec3(0.3, 0.1, 4.0)};
    // Six features in the second camera and three in the first: the second one gives the start.
    PoseObservations seen;
    for (std::size_t f = 0; f < 8; ++f) {
      if (f < 3) CHECK(test::see(rig, target, truth, 0, f, 0.5, rng, seen));
      if (f >= 2) CHECK(test::see(rig, target, truth, 1, f, 0.5, rng, seen));
    }
    AcquiredPose a;
    CHECK(acquire_pose(rig, target, seen, test::all_used(), {}, a) == Status::ok);
    LONGS_EQUAL(static_cast<int>(seen.size()), a.best.used);
    const Vec6 e = test::pose_difference(a.best.pose, truth);
    wrong += test::mahalanobis_squared(e, a.best.covariance) > 40.0 ? 1 : 0;
  }
  LONGS_EQUAL(0, wrong);
}

TEST(PoseAcquisition, says_what_is_missing_and_leaves_the_output_alone) {
  test::Normal rng(6);
  const CameraRig rig = test::mono_rig(test::pinhole());
  const CameraRig pair = test::stereo_rig(test::pinhole(), test::pinhole(), Mat3::Identity(), Vec3(0.5, 0.0, 0.0));
  const TargetModel target = test::target_of(test::cube(0.3));
  const Pose truth{test::random_attitude(rng), Vec3(0.1, 0.1, 4.0)};
  AcquiredPose a;
  a.best.chi2 = -4.0;
  a.best.used = -5;
  const auto status_of = [&](const CameraRig& with, const TargetModel& of, const PoseObservations& seen) {
    const Status status = acquire_pose(with, of, seen, test::all_used(), {}, a);
    CHECK(a.best.chi2 == -4.0 && a.best.used == -5 && !a.ambiguous);
    return status;
  };
  PoseObservations seen = test::see_all(rig, target, truth, 0.5, rng);
  PoseObservations bad = seen;
  bad.truncate(3);
  CHECK(status_of(rig, target, bad) == Status::too_few_features);
  CHECK(status_of(rig, target, PoseObservations()) == Status::too_few_features);
  bad = test::see_all(pair, target, truth, 0.5, rng);
  bad[3] = bad[8];  // three in each camera
  bad[4] = bad[9];
  bad[5] = bad[10];
  bad.truncate(6);
  CHECK(status_of(pair, target, bad) == Status::too_few_features);

  for (int i = 0; i < 100; ++i) {
    const Vec3 at = 0.3 * rng.vec3();
    const Vec3 along = 0.3 * rng.vec3();
    const TargetModel line = test::target_of({at, at + along, at - along, at + 0.3 * along, at - 0.7 * along});
    CHECK(status_of(rig, line, test::see_all(rig, line, truth, 0.5, rng)) == Status::rank_deficient);
  }

  bad = seen;
  bad[6].feature = 8;
  CHECK(status_of(rig, target, bad) == Status::invalid_argument);
  bad = seen;
  bad[6].camera = 1;  // one stray observation: the rig has no such camera
  CHECK(status_of(rig, target, bad) == Status::invalid_argument);
  for (PoseObservation& o : bad) o.camera = 1;
  CHECK(status_of(rig, target, bad) == Status::invalid_argument);
  bad = seen;
  bad[6].sigma_px = 0.0;
  CHECK(status_of(rig, target, bad) == Status::invalid_argument);
}

TEST(PoseAcquisition, a_bad_index_in_the_camera_that_sees_less_is_a_status) {
  test::Normal rng(7);
  const CameraRig pair = test::stereo_rig(test::pinhole(), test::pinhole(), Mat3::Identity(), Vec3(0.5, 0.0, 0.0));
  const TargetModel target = test::target_of(test::cube(0.3));
  PoseObservations seen;
  const Pose truth{test::random_attitude(rng), Vec3(0.1, 0.1, 4.0)};
  for (std::size_t f = 0; f < 8; ++f) CHECK(test::see(pair, target, truth, 0, f, 0.5, rng, seen));
  CHECK(test::see(pair, target, truth, 1, 0, 0.5, rng, seen));
  seen[8].feature = 8;
  AcquiredPose a;
  CHECK(acquire_pose(pair, target, seen, test::all_used(), {}, a) == Status::invalid_argument);
}

TEST(PoseAcquisition, one_of_the_two_starts_is_near) {
  test::Normal rng(8);
  const CameraRig rig = test::mono_rig(test::long_focus());
  const TargetModel target = test::target_of(test::cube(1.0));
  double worst_deg = 0.0;
  for (int i = 0; i < 500; ++i) {
    const Pose truth{test::random_attitude(rng), Vec3(1.0, -2.0, 100.0)};
    const PoseObservations seen = test::see_all(rig, target, truth, 1.0, rng, 0.0);
    std::array<Pose, 2> starts;
    CHECK(orthographic_starts(rig, target, seen, test::all_used(), 0, starts) == Status::ok);
    const double angle =
        std::min(test::rotation_angle(truth.R_CT, starts[0].R_CT), test::rotation_angle(truth.R_CT, starts[1].R_CT));
    worst_deg = std::max(worst_deg, angle * degrees_per_radian);
  }
  std::printf("    starts without noise: the nearer one within %.1f deg\n", worst_deg);
  CHECK(worst_deg < 20.0);
  std::array<Pose, 2> starts;
  CHECK(orthographic_starts(rig, target, PoseObservations(), test::all_used(), 1, starts) == Status::invalid_argument);
}

}  // namespace relnav
