// solve_pose() and PoseIteration against an independent maximum-likelihood solver, the Cramer-Rao bound, and each other in
// double, float and fixed point.
#include "fsw/estimation/pose_least_squares.hpp"

#include <array>
#include <cmath>
#include <cstdio>
#include <limits>

#include "fsw/attitude/rodrigues.hpp"
#include "fsw/estimation/pose_iteration.hpp"
#include "fsw/math/fixed.hpp"
#include "tests/support/dense.hpp"
#include "tests/unit/estimation/pose_samples.hpp"

#include <CppUTest/TestHarness.h>

namespace relnav {
namespace {

constexpr double quiet_nan = std::numeric_limits<double>::quiet_NaN();

/// A target of a metre, seen at three to four metres anywhere in the middle of the image.
Pose random_pose(test::Normal& rng, int i = 0) {
  Pose pose;
  pose.R_CT = i % 4 == 3 ? test::random_half_turn(rng) : test::random_attitude(rng);
  const double range = 3.0 + rng.generator().uniform();
  pose.t_CT = range * rng.ahead(0.2);
  return pose;
}

/// As the last epoch would leave it: a few degrees and per cent away.
Pose nearby(const Pose& pose, test::Normal& rng, double size = 0.05) {
  Vec6 d;
  d << pose.t_CT.norm() * size * rng.vec3(), size * rng.vec3();
  return test::moved_pose(pose, d);
}

/// With noise that pixels have, and an uneven layout: no two features alike, none on an axis.
std::vector<Vec3> uneven_target(test::Normal& rng, std::size_t count) {
  std::vector<Vec3> points = test::cube(0.4);
  points.resize(count, Vec3::Zero());
  for (Vec3& p : points) p += 0.1 * rng.vec3();
  return points;
}

CameraRig random_rig(test::Normal& rng, int i) {
  constexpr DistortionModel models[] = {DistortionModel::none, DistortionModel::radial_tangential,
                                        DistortionModel::radial_inverse, DistortionModel::equidistant};
  const CameraIntrinsics first = test::distorted(models[i % 4]);
  if (i % 2 == 0) return test::mono_rig(first);
  // The second camera: a metre or so aside, turned toward the target and about its axis by anything.
  const double roll = 6.28 * rng.generator().uniform();
  const double side = (rng.generator().below(2) == 0 ? 1.0 : -1.0) * (0.5 + rng.generator().uniform());
  const Vec2 tilt = 0.1 * rng.vec2();
  const Vec2 shift = 0.1 * rng.vec2();
  const Mat3 R_10 = test::reference_dcm(Vec3(0, 0, 1), roll) *
                    test::reference_dcm(Vec3(tilt.x(), 1, tilt.y()), std::atan(side / 3.5));
  return test::stereo_rig(first, test::distorted(models[i / 2 % 4]), R_10, Vec3(side, shift.x(), shift.y()));
}

PoseEstimate sentinel() {
  PoseEstimate e;
  e.pose.t_CT = Vec3(-1.0, -2.0, -3.0);
  e.chi2 = -4.0;
  e.used = -5;
  e.iterations = -6;
  e.degrees_of_freedom = -7;
  e.covariance.setConstant(-8.0);
  return e;
}
void check_untouched(const PoseEstimate& e) {
  const PoseEstimate expected = sentinel();
  CHECK(e.pose.R_CT == expected.pose.R_CT);
  CHECK(e.pose.t_CT == expected.pose.t_CT);
  CHECK(e.covariance == expected.covariance);
  CHECK(e.chi2 == expected.chi2 && e.used == expected.used && e.iterations == expected.iterations &&
        e.degrees_of_freedom == expected.degrees_of_freedom);
}

}  // namespace

TEST_GROUP(PoseLeastSquares){};

namespace {

TEST(PoseLeastSquares, recovers_the_pose_of_exact_images) {
  test::Normal rng(1);
  double worst = 0.0;
  for (int i = 0; i < 200; ++i) {
    const CameraRig rig = random_rig(rng, i);
    const TargetModel target = test::target_of(uneven_target(rng, 8));
    const Pose truth = random_pose(rng, i / 2);
    const PoseObservations seen = test::see_all(rig, target, truth, 1.0, rng, 0.0);
    PoseEstimate e;
    CHECK(solve_pose(rig, target, seen, test::all_used(), nearby(truth, rng), {}, e) == Status::ok);
    worst = std::max(worst, test::pose_difference(truth, e.pose).norm());
  }
  std::printf("    exact images: error %.1e\n", worst);
  CHECK(worst < 1e-8);  // it stops within 1e-5 sigma, with a pixel as sigma
}

TEST(PoseLeastSquares, is_the_independent_optimum_in_one_and_two_cameras_with_distortion) {
  test::Normal rng(2);
  double worst_sigma = 0.0;
  double worst_gradient = 0.0;
  double worst_chi2 = 0.0;
  double worst_covariance = 0.0;
  int most_iterations = 0;
  for (int i = 0; i < 200; ++i) {
    const CameraRig rig = random_rig(rng, i);
    const TargetModel target = test::target_of(uneven_target(rng, 6 + static_cast<std::size_t>(i) % 3));
    const Pose truth = random_pose(rng, i / 2);
    PoseObservations seen;
    for (std::size_t c = 0; c < rig.size(); ++c) {
      for (std::size_t f = 0; f < target.features.size(); ++f) {
        if (c == 1 && f % 3 == 1) continue;  // seen by the first camera only
        CHECK(test::see(rig, target, truth, c, f, 0.3 + 0.1 * static_cast<double>(f), rng, seen));
      }
    }
    PoseEstimate e;
    CHECK(solve_pose(rig, target, seen, test::all_used(), nearby(truth, rng), {}, e) == Status::ok);
    const Pose optimum = test::reference_optimum(rig, target, seen, truth);
    const Eigen::MatrixXd J = test::pose_jacobian(rig, target, seen, e.pose);
    const Eigen::VectorXd r = test::residuals(rig, target, seen, e.pose);
    worst_sigma = std::max(worst_sigma, (J * test::pose_difference(optimum, e.pose)).norm());
    // Whitened gradient: the step that a numeric Jacobian would still make, in sigmas.
    worst_gradient = std::max(worst_gradient, (J * test::solve_least_squares(J, r)).norm());
    worst_chi2 = std::max(worst_chi2, std::fabs(e.chi2 - r.squaredNorm()));
    const Mat6 bound = test::pose_bound(rig, target, seen, e.pose);
    const Vec6 scale = bound.diagonal().cwiseSqrt().cwiseInverse();
    worst_covariance = std::max(
        worst_covariance, (scale.asDiagonal() * (e.covariance - bound) * scale.asDiagonal()).cwiseAbs().maxCoeff());
    most_iterations = std::max(most_iterations, e.iterations);
    LONGS_EQUAL(static_cast<int>(seen.size()), e.used);
    LONGS_EQUAL(2 * e.used - 6, e.degrees_of_freedom);
  }
  std::printf("    optimum: %.1e sigma away, gradient %.1e sigma, chi2 %.1e, covariance %.1e, at most %d iterations\n",
              worst_sigma, worst_gradient, worst_chi2, worst_covariance, most_iterations);
  CHECK(worst_sigma < 1e-6);
  CHECK(worst_gradient < 1e-6);
  CHECK(worst_chi2 < 1e-8);
  CHECK(worst_covariance < 1e-3);  // of the last linearisation, one small step before the end
  CHECK(most_iterations <= 8);
}

TEST(PoseLeastSquares, reaches_the_cramer_rao_bound_and_knows_its_error) {
  constexpr int epochs = 10000;
  constexpr double sigma_px = 0.5;
  test::Normal rng(3);
  const CameraRig rig = test::mono_rig(test::pinhole());
  const TargetModel target = test::target_of(test::cube(0.3));  // 1.04 m across the diagonal, at 3 to 4 m
  Vec6 sum = Vec6::Zero();
  double nees = 0.0;
  double nees_of_bound = 0.0;
  double chi2 = 0.0;
  int iterations = 0;
  int most_iterations = 0;
  for (int i = 0; i < epochs; ++i) {
    const Pose truth = random_pose(rng, i);
    const PoseObservations seen = test::see_all(rig, target, truth, sigma_px, rng);
    PoseEstimate e;
    CHECK(solve_pose(rig, target, seen, test::all_used(), nearby(truth, rng), {}, e) == Status::ok);
    const Vec6 error = test::pose_difference(e.pose, truth);
    const Mat6 bound = test::pose_bound(rig, target, seen, truth);
    sum += error.cwiseAbs2().cwiseQuotient(bound.diagonal());
    nees += test::mahalanobis_squared(error, e.covariance) / epochs;
    nees_of_bound += test::mahalanobis_squared(error, bound) / epochs;
    chi2 += e.chi2 / epochs;
    iterations += e.iterations;
    most_iterations = std::max(most_iterations, e.iterations);
  }
  const Vec6 ratio = (sum / epochs).cwiseSqrt();
  std::printf(
      "    RMS/CRLB %.3f %.3f %.3f, %.3f %.3f %.3f; NEES %.3f (with the bound at the truth: %.3f), chi2 %.3f / 10\n",
      ratio(0), ratio(1), ratio(2), ratio(3), ratio(4), ratio(5), nees, nees_of_bound, chi2);
  std::printf("    iterations: mean %.2f, most %d\n", static_cast<double>(iterations) / epochs, most_iterations);
  CHECK(ratio.maxCoeff() < 1.05);
  CHECK(ratio.minCoeff() > 0.95);
  CHECK(nees > 5.9 && nees < 6.1);
  CHECK(chi2 > 9.85 && chi2 < 10.15);
  CHECK(most_iterations <= 8);
}

TEST(PoseLeastSquares, a_feature_seen_by_one_camera_only_counts) {
  test::Normal rng(4);
  const CameraRig rig = test::stereo_rig(test::pinhole(), test::pinhole(), Mat3::Identity(), Vec3(1.0, 0.0, 0.0));
  const TargetModel target = test::target_of(test::cube(0.3));
  const Pose truth = random_pose(rng);
  // Three features in the first camera, the other five in the second: no point can be triangulated.
  PoseObservations seen;
  for (std::size_t f = 0; f < 8; ++f) CHECK(test::see(rig, target, truth, f < 3 ? 0 : 1, f, 0.5, rng, seen));
  PoseEstimate e;
  CHECK(solve_pose(rig, target, seen, test::all_used(), nearby(truth, rng), {}, e) == Status::ok);
  const Vec6 error = test::pose_difference(e.pose, truth);
  CHECK(test::mahalanobis_squared(error, e.covariance) < 25.0);
  LONGS_EQUAL(8, e.used);
  // Each of the five makes the covariance smaller.
  ObservationMask used = test::all_used();
  for (std::size_t f = 7; f > 4; --f) {
    used[f] = false;
    PoseEstimate fewer;
    CHECK(solve_pose(rig, target, seen, used, truth, {}, fewer) == Status::ok);
    LONGS_EQUAL(static_cast<int>(f), fewer.used);
    CHECK(test::eigenvalues_of(fewer.covariance).prod() > 1.1 * test::eigenvalues_of(e.covariance).prod());
    e = fewer;
  }
}

TEST(PoseLeastSquares, what_is_not_used_does_not_matter) {
  test::Normal rng(5);
  const CameraRig rig = test::mono_rig(test::pinhole());
  const TargetModel target = test::target_of(test::cube(0.3));
  const Pose truth = random_pose(rng);
  PoseObservations seen = test::see_all(rig, target, truth, 0.5, rng);
  ObservationMask used = test::all_used();
  used[2] = used[5] = false;
  PoseEstimate clean;
  CHECK(solve_pose(rig, target, seen, used, truth, {}, clean) == Status::ok);
  seen[2].uv_px = Vec2(quiet_nan, 0.0);
  seen[5].feature = 4000;
  PoseEstimate spoilt;
  CHECK(solve_pose(rig, target, seen, used, truth, {}, spoilt) == Status::ok);
  CHECK(clean.pose.R_CT == spoilt.pose.R_CT);
  CHECK(clean.pose.t_CT == spoilt.pose.t_CT);
  LONGS_EQUAL(6, spoilt.used);
}

TEST(PoseLeastSquares, huber_loss_bounds_what_an_outlier_can_do) {
  test::Normal rng(6);
  const CameraRig rig = test::mono_rig(test::pinhole());
  const TargetModel target = test::target_of(test::cube(0.3));
  double worst = 0.0;
  double least_without = 1e9;
  double growth = 0.0;
  for (int i = 0; i < 100; ++i) {
    const Pose truth = random_pose(rng, i);
    const PoseObservations clean = test::see_all(rig, target, truth, 0.5, rng);
    PoseSolverSettings robust;
    robust.huber_sigma = 2.0;
    const auto shift = [&](double outlier_px, const PoseSolverSettings& settings) {
      PoseEstimate reference;
      CHECK(solve_pose(rig, target, clean, test::all_used(), truth, settings, reference) == Status::ok);
      PoseObservations seen = clean;
      seen[static_cast<std::size_t>(i) % 8].uv_px += outlier_px * Vec2(0.6, 0.8);
      PoseEstimate e;
      CHECK(solve_pose(rig, target, seen, test::all_used(), truth, settings, e) == Status::ok);
      const Vec6 d = test::pose_difference(reference.pose, e.pose);
      return std::sqrt(test::mahalanobis_squared(d, reference.covariance));
    };
    const double at_20 = shift(20.0, robust);
    worst = std::max(worst, at_20);
    growth = std::max(growth, shift(60.0, robust) - at_20);
    least_without = std::min(least_without, shift(20.0, {}));
  }
  std::printf(
      "    outlier of 40 sigma: moves the pose by at most %.2f sigma with Huber's loss (120 sigma: %.2f more), "
      "without at least %.2f\n",
      worst, growth, least_without);
  CHECK(worst < 6.0);
  CHECK(growth < 0.5);
  CHECK(least_without > 10.0);
}

TEST(PoseLeastSquares, huber_cost_is_the_loss) {
  test::Normal rng(7);
  const CameraRig rig = test::mono_rig(test::pinhole());
  const TargetModel target = test::target_of(test::cube(0.3));
  const Pose truth = random_pose(rng);
  PoseObservations seen = test::see_all(rig, target, truth, 0.5, rng);
  seen[3].uv_px.x() += 20.0;
  PoseSolverSettings robust;
  robust.huber_sigma = 1.5;
  PoseEstimate e;
  CHECK(solve_pose(rig, target, seen, test::all_used(), truth, robust, e) == Status::ok);
  const auto loss = [&](const Pose& pose) {
    const Eigen::VectorXd r = test::residuals(rig, target, seen, pose);
    double sum = 0.0;
    for (Eigen::Index i = 0; i < r.size(); i += 2) {
      const double size = r.segment<2>(i).norm();
      sum += size > 1.5 ? 2.0 * 1.5 * size - 1.5 * 1.5 : size * size;
    }
    return sum;
  };
  DOUBLES_EQUAL(loss(e.pose), e.chi2, 1e-6);
  // And its minimum.
  for (int k = 0; k < 6; ++k) {
    for (const double side : {1.0, -1.0}) {
      Vec6 d = Vec6::Zero();
      d(k) = side * 0.1 * std::sqrt(e.covariance(k, k));
      CHECK(loss(test::moved_pose(e.pose, d)) > e.chi2);
    }
  }
}

TEST(PoseLeastSquares, says_what_is_wrong_and_leaves_the_output_alone) {
  test::Normal rng(8);
  const CameraRig rig = test::mono_rig(test::pinhole());
  const TargetModel target = test::target_of(test::cube(0.3));
  const Pose truth = random_pose(rng);
  const PoseObservations seen = test::see_all(rig, target, truth, 0.5, rng);
  PoseEstimate e = sentinel();
  const auto status_of = [&](const PoseObservations& observations, const Pose& start) {
    const Status status = solve_pose(rig, target, observations, test::all_used(), start, {}, e);
    check_untouched(e);
    return status;
  };
  PoseObservations bad = seen;
  bad.truncate(2);
  CHECK(status_of(bad, truth) == Status::too_few_features);
  CHECK(status_of(PoseObservations(), truth) == Status::too_few_features);

  for (const double sigma_px : {0.0, -1.0, quiet_nan, HUGE_VAL}) {
    bad = seen;
    bad[4].sigma_px = sigma_px;
    CHECK(status_of(bad, truth) == Status::invalid_argument);
  }
  for (const double u_px : {quiet_nan, HUGE_VAL}) {
    bad = seen;
    bad[4].uv_px.y() = u_px;
    CHECK(status_of(bad, truth) == Status::invalid_argument);
  }
  bad = seen;
  bad[7].feature = 8;
  CHECK(status_of(bad, truth) == Status::invalid_argument);
  bad = seen;
  bad[7].camera = 1;
  CHECK(status_of(bad, truth) == Status::invalid_argument);

  Pose start = truth;
  start.t_CT.z() = -start.t_CT.z();
  CHECK(status_of(seen, start) == Status::behind_camera);
  start.t_CT.z() = quiet_nan;
  CHECK(status_of(seen, start) != Status::ok);
  start = truth;
  start.R_CT(1, 1) = quiet_nan;
  CHECK(status_of(seen, start) != Status::ok);
}

TEST(PoseLeastSquares, one_feature_seen_often_and_features_on_a_line_are_rank_deficient) {
  test::Normal rng(9);
  for (int i = 0; i < 200; ++i) {
    const CameraRig rig = random_rig(rng, i);
    const Pose truth = random_pose(rng, i);
    const Vec3 a = 0.3 * rng.vec3();
    const Vec3 b = 0.3 * rng.vec3();
    TargetModel line = test::target_of({a, a + b, a - b, a + 0.5 * b, a + 0.125 * b});
    PoseEstimate e = sentinel();
    PoseObservations seen = test::see_all(rig, line, truth, 0.5, rng);
    CHECK(solve_pose(rig, line, seen, test::all_used(), truth, {}, e) == Status::rank_deficient);
    for (PoseObservation& o : seen) o.feature = 0;
    CHECK(solve_pose(rig, line, seen, test::all_used(), truth, {}, e) == Status::rank_deficient);
    check_untouched(e);
  }
}

TEST(PoseLeastSquares, three_features_are_enough) {
  test::Normal rng(10);
  const CameraRig rig = test::mono_rig(test::pinhole());
  const TargetModel target = test::target_of({Vec3(0.4, 0, 0), Vec3(-0.2, 0.4, 0.1), Vec3(-0.1, -0.4, -0.1)});
  const Pose truth{test::reference_dcm(Vec3(1, 2, 3), 0.6), Vec3(0.1, 0.1, 3.0)};
  const PoseObservations seen = test::see_all(rig, target, truth, 0.5, rng, 0.0);
  PoseEstimate e;
  CHECK(solve_pose(rig, target, seen, test::all_used(), nearby(truth, rng, 0.01), {}, e) == Status::ok);
  CHECK(test::pose_difference(truth, e.pose).norm() < 1e-8);
  LONGS_EQUAL(0, e.degrees_of_freedom);
}

TEST(PoseLeastSquares, iterations_are_bounded_whatever_the_start) {
  test::Normal rng(11);
  const CameraRig rig = test::mono_rig(test::pinhole());
  const TargetModel target = test::target_of(test::cube(0.3));
  int converged = 0;
  int right = 0;
  for (int i = 0; i < 2000; ++i) {
    const Pose truth = random_pose(rng, i);
    const PoseObservations seen = test::see_all(rig, target, truth, 0.5, rng);
    const Pose start{test::random_attitude(rng), truth.t_CT * (0.5 + 2.0 * rng.generator().uniform())};
    PoseEstimate e = sentinel();
    const Status status = solve_pose(rig, target, seen, test::all_used(), start, {}, e);
    if (status != Status::ok) {
      check_untouched(e);
      CHECK(status == Status::no_convergence || status == Status::rank_deficient || status == Status::behind_camera);
      continue;
    }
    ++converged;
    CHECK(e.iterations >= 1 && e.iterations <= 100);
    CHECK(e.pose.R_CT.allFinite() && e.pose.t_CT.allFinite() && e.covariance.allFinite());
    if (e.chi2 < 60.0) ++right;
  }
  std::printf("    any start at all: %d of 2000 converge, %d to the right pose\n", converged, right);
  CHECK(right > 1000);

  const Pose truth = random_pose(rng);
  const PoseObservations seen = test::see_all(rig, target, truth, 0.5, rng);
  PoseSolverSettings settings;
  settings.max_iterations = 1;
  PoseEstimate e = sentinel();
  CHECK(solve_pose(rig, target, seen, test::all_used(), nearby(truth, rng, 0.1), settings, e) ==
        Status::no_convergence);
  check_untouched(e);
}

TEST(PoseLeastSquares, whitened_residual_is_observed_minus_predicted_over_sigma) {
  test::Normal rng(12);
  const CameraRig rig = random_rig(rng, 1);
  const TargetModel target = test::target_of(test::cube(0.3));
  const Pose truth = random_pose(rng);
  const PoseObservations seen = test::see_all(rig, target, truth, 0.25, rng);
  const Eigen::VectorXd expected = test::residuals(rig, target, seen, truth);
  for (std::size_t i = 0; i < seen.size(); ++i) {
    Vec2 r;
    CHECK(whitened_residual(rig, target, seen[i], truth, r) == Status::ok);
    CHECK((r - expected.segment<2>(2 * static_cast<Eigen::Index>(i))).norm() < 1e-9);
  }
  Vec2 r(7.0, 8.0);
  PoseObservation bad = seen[0];
  bad.sigma_px = 0.0;
  CHECK(whitened_residual(rig, target, bad, truth, r) == Status::invalid_argument);
  Pose behind = truth;
  behind.t_CT.z() = -10.0;
  CHECK(whitened_residual(rig, target, seen[0], behind, r) != Status::ok);
  CHECK(r == Vec2(7.0, 8.0));
}

// ---- Any scalar: a pinhole in normalised coordinates, lengths over the range.

template <typename S>
struct PinholeRows {
  std::array<Eigen::Matrix<S, 3, 1>, 8> p_T;
  std::array<Eigen::Matrix<S, 2, 1>, 8> xy;

  Status operator()(int i, const Eigen::Matrix<S, 3, 3>& R_CT, const Eigen::Matrix<S, 3, 1>& t, PoseRow<S>& row) const {
    const auto at = static_cast<std::size_t>(i);
    for (int k = 0; k < 3; ++k) {
      row.X_r(k) = R_CT(k, 0) * p_T[at](0) + R_CT(k, 1) * p_T[at](1) + R_CT(k, 2) * p_T[at](2);
    }
    const S z = row.X_r(2) + t(2);
    if (!(z > S(0.1))) return Status::behind_camera;
    const S w = S(1) / z;
    const S x = (row.X_r(0) + t(0)) * w;
    const S y = (row.X_r(1) + t(1)) * w;
    row.J << w, S(0), -(x * w), S(0), w, -(y * w);
    row.r << xy[at](0) - x, xy[at](1) - y;
    row.axis << S(0), S(0), S(1);
    row.depth = z;
    return Status::ok;
  }
};

struct Scene {
  std::vector<Vec3> points = test::cube(0.1);  // over the range
  Pose truth;
  std::array<Vec2, 8> xy;

  Scene(const Pose& pose, double noise, test::Normal& rng) : truth(pose) {
    for (std::size_t i = 0; i < 8; ++i) {
      const Vec3 p = pose.R_CT * points[i] + pose.t_CT;
      xy[i] = Vec2(p.head<2>() / p.z()) + noise * rng.vec2();
    }
  }
  template <typename S>
  [[nodiscard]] PinholeRows<S> rows() const {
    PinholeRows<S> out;
    for (std::size_t i = 0; i < 8; ++i) {
      for (int k = 0; k < 3; ++k) out.p_T[i](k) = S(points[i](k));
      for (int k = 0; k < 2; ++k) out.xy[i](k) = S(xy[i](k));
    }
    return out;
  }
};

template <typename S>
IterationLimits<S> limits_of(double gain, double step, double slack, double pivot) {
  IterationLimits<S> limits;
  limits.gain = S(gain);
  limits.step = S(step);
  limits.cost_slack = S(slack);
  limits.least_pivot = S(pivot);
  return limits;
}
template <typename S>
IterationLimits<S> default_limits();
template <>
IterationLimits<double> default_limits<double>() {
  return limits_of<double>(0.0, 1e-12, 1e-15, 1e-13);
}
template <>
IterationLimits<float> default_limits<float>() {
  return limits_of<float>(0.0, 2e-5, 1e-7, 1e-6);
}
template <>
IterationLimits<FixedQ47> default_limits<FixedQ47>() {
  return limits_of<FixedQ47>(0.0, 1e-10, 1e-12, 1e-9);
}

template <typename S>
void start_at(PoseIteration<S>& iteration, const Pose& pose) {
  const RodriguesChart chart = RodriguesChart::from_dcm(pose.R_CT);
  for (int k = 0; k < 3; ++k) {
    iteration.attitude.g(k) = S(chart.parameters()(k));
    iteration.t(k) = S(pose.t_CT(k));
  }
  iteration.attitude.set = chart.set_index();
}

template <typename S>
Pose pose_of(const PoseIteration<S>& iteration) {
  const auto R = iteration.attitude.dcm();
  Pose pose;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) pose.R_CT(r, c) = static_cast<double>(R(r, c));
    pose.t_CT(r) = static_cast<double>(iteration.t(r));
  }
  return pose;
}

template <typename S>
Pose solved(const Scene& scene, const Pose& start) {
  PoseIteration<S> iteration;
  start_at(iteration, start);
  CHECK(iteration.solve(8, scene.rows<S>(), default_limits<S>()) == Status::ok);
  CHECK(iteration.iterations() <= 12);
  return pose_of(iteration);
}

Pose at_unit_range(test::Normal& rng, int i) {
  Pose pose = random_pose(rng, i);
  pose.t_CT /= pose.t_CT.z();
  return pose;
}

TEST(PoseLeastSquares, float_and_fixed_point_agree_with_double) {
  test::Normal rng(13);
  Vec2 in_float = Vec2::Zero();  // attitude rad, position over range
  Vec2 in_fixed = Vec2::Zero();
  for (int i = 0; i < 400; ++i) {
    const Scene scene(at_unit_range(rng, i), 5e-4, rng);
    const Pose start = nearby(scene.truth, rng, 0.03);
    const Pose reference = solved<double>(scene, start);
    const Vec6 f = test::pose_difference(reference, solved<float>(scene, start));
    const Vec6 q = test::pose_difference(reference, solved<FixedQ47>(scene, start));
    in_float = in_float.cwiseMax(Vec2(f.tail<3>().norm(), f.head<3>().norm()));
    in_fixed = in_fixed.cwiseMax(Vec2(q.tail<3>().norm(), q.head<3>().norm()));
  }
  std::printf("    against double: float %.1e rad, %.1e of the range; fixed %.1e rad, %.1e of the range\n", in_float(0),
              in_float(1), in_fixed(0), in_fixed(1));
  CHECK(in_float.maxCoeff() < 1e-4);
  CHECK(in_fixed.maxCoeff() < 1e-9);
}

TEST(PoseLeastSquares, an_overflowed_cost_is_not_a_low_one) {
  test::Normal rng(15);
  const Scene scene(at_unit_range(rng, 0), 5e-4, rng);
  const Pose start = nearby(scene.truth, rng, 0.03);
  const auto rows = scene.rows<FixedQ47>();
  int calls = 0;
  const auto row_of = [&](int i, const auto& R_CT, const auto& t_CT, PoseRow<FixedQ47>& row) {
    const Status status = rows(i, R_CT, t_CT, row);
    ++calls;
    if (calls > 8 && calls <= 16)
      row.r.setConstant(FixedQ47(1) / FixedQ47(0) * FixedQ47(0));  // the first step: 0, flagged
    return status;
  };
  PoseIteration<FixedQ47> iteration;
  start_at(iteration, start);
  CHECK(iteration.solve(8, row_of, default_limits<FixedQ47>()) == Status::ok);
  CHECK(is_sound(iteration.t) && is_sound(iteration.cost()));
  CHECK(test::pose_difference(solved<FixedQ47>(scene, start), pose_of(iteration)).norm() < 1e-9);
}

struct Turn {
  bool failed = false;     ///< a status other than ok, or saturated
  double worst_rad = 0.0;  ///< error where it did not fail
};

bool is_saturated(const GibbsSet<double>& a) { return !a.g.allFinite(); }
bool is_saturated(const GibbsSet<FixedQ47>& a) {
  return a.g(0).overflowed() || a.g(1).overflowed() || a.g(2).overflowed();
}

/// A target turning through 180 deg, exactly 180 deg being one of the epochs; each starts from the one before.
template <typename S>
Turn turned_through_half_a_turn(const Vec3& axis, bool switching) {
  test::Normal rng(14);
  PoseIteration<S> iteration;
  start_at(iteration, {test::reference_dcm(axis, test::pi_l * 170 / 180), Vec3(0.02, -0.03, 1.0)});
  if (!switching) {
    iteration.attitude.g = Eigen::Matrix<S, 3, 1>(S(0), S(0), S(0));
    iteration.attitude.set = 0;
    for (int k = 0; k < 3; ++k) {
      iteration.attitude.g(k) = S(-axis.normalized()(k) * std::tan(0.5 * 170.0 / test::degrees_per_radian));
    }
  }
  IterationLimits<S> limits = default_limits<S>();
  limits.switching = switching;
  Turn out;
  for (int i = 0; i <= 20; ++i) {
    const Scene scene({test::reference_dcm(axis, test::pi_l * (170 + i) / 180), Vec3(0.02, -0.03, 1.0)}, 0.0, rng);
    const Status status = iteration.solve(8, scene.rows<S>(), limits);
    if (status != Status::ok || is_saturated(iteration.attitude)) {
      out.failed = true;
      return out;
    }
    out.worst_rad = std::max(out.worst_rad, test::rotation_angle(scene.truth.R_CT, pose_of(iteration).R_CT));
  }
  return out;
}

TEST(PoseLeastSquares, half_a_turn_needs_switching_in_fixed_point_but_not_in_double) {
  for (const Vec3& axis : {Vec3(1, 0, 0), Vec3(0, 0, 1), Vec3(1, 1, 1), Vec3(0.3, -0.8, 0.5)}) {
    const Turn with = turned_through_half_a_turn<FixedQ47>(axis, true);
    const Turn without = turned_through_half_a_turn<FixedQ47>(axis, false);
    const Turn with_double = turned_through_half_a_turn<double>(axis, true);
    const Turn without_double = turned_through_half_a_turn<double>(axis, false);
    std::printf("    about (%.1f %.1f %.1f): fixed %.1e, without switching %s (%.1e); double %.1e, without %.1e\n",
                axis(0), axis(1), axis(2), with.worst_rad, without.failed ? "fails" : "works", without.worst_rad,
                with_double.worst_rad, without_double.worst_rad);
    CHECK_FALSE(with.failed);
    CHECK(with.worst_rad < 1e-9);
    CHECK(without.failed || without.worst_rad > 0.01);
    CHECK_FALSE(with_double.failed);
    CHECK(with_double.worst_rad < 1e-12);
    CHECK_FALSE(without_double.failed);
    CHECK(without_double.worst_rad < 1e-9);
  }
}

TEST(PoseLeastSquares, a_step_to_the_pole_of_the_composition_is_shortened) {
  // g = (1, 1, 1) at the bound and a system whose solution is dg = (1, 1, 1) / 3: 1 - dg'g = 0 in (10).
  const auto solve_with = [](auto zero, double dg, const auto& limits) {
    using S = decltype(zero);
    PoseIteration<S> iteration;
    iteration.attitude.g = Eigen::Matrix<S, 3, 1>(S(1), S(1), S(1));
    int calls = 0;
    const auto row_of = [&](int i, const auto&, const auto&, PoseRow<S>& row) {
      // Point on axis i; residuals of the two image directions across it. Solved exactly at the first step.
      row.X_r = Eigen::Matrix<S, 3, 1>(S(0), S(0), S(0));
      row.X_r(i % 3) = S(i < 3 ? 1 : -1);
      const int a = (i + 1) % 3;
      const int b = (i + 2) % 3;
      row.J << S(0), S(0), S(0), S(0), S(0), S(0);
      row.J(0, a) = S(1);
      row.J(1, b) = S(1);
      const S size = calls++ < 6 ? S(2.0 * dg) : S(0);
      // Displacement of X under dg: 2 X x ... = row' 2 [X x] dg.
      const S side = row.X_r(i % 3);
      row.r << -(side * size), side * size;
      return Status::ok;
    };
    CHECK(iteration.solve(6, row_of, limits) == Status::ok);
    for (int k = 0; k < 3; ++k) CHECK(iteration.attitude.g(k) <= S(1) && iteration.attitude.g(k) >= S(-1));
    CHECK_FALSE(is_saturated(iteration.attitude));
  };
  for (const double dg : {1.0 / 3.0, 0.3333, 0.33, 0.4, 0.5, 2.0}) {
    solve_with(0.0, dg, default_limits<double>());
    solve_with(FixedQ47(0), dg, default_limits<FixedQ47>());
  }
}

}  // namespace
}  // namespace relnav
