// solve_scaled_pose: the same optimum in double, float and fixed point, from starts that are off, at every scale; what
// leaves the range is said.
#include "fsw/estimation/scaled_pose_solver.hpp"

#include <cmath>
#include <cstdio>

#include "fsw/attitude/so3.hpp"
#include "tests/support/campaign.hpp"
#include "tests/support/dense.hpp"
#include "tests/unit/estimation/pose_samples.hpp"

#include <CppUTest/TestHarness.h>

namespace relnav {
namespace {

using test::degrees_per_radian;
using test::reference_dcm;

constexpr int poses = test::campaign(10000, 200);

struct Setting {
  const char* name;
  CameraRig rig;
  TargetModel target;
  double range;
};

std::vector<Setting> settings() {
  const CameraRig two = test::stereo_rig(test::pinhole(), test::distorted(DistortionModel::radial_tangential),
                                         reference_dcm(Vec3::UnitY(), 0.12), Vec3(0.8, 0.05, -0.02));
  std::vector<Vec3> small = test::cube(0.004);
  return {{"near", test::mono_rig(test::pinhole()), test::target_of(test::cube(0.5)), 4.0},
          {"distorted", test::mono_rig(test::distorted(DistortionModel::equidistant)), test::target_of(test::cube(0.5)),
           6.0},
          {"far", test::mono_rig(test::long_focus()), test::target_of(test::cube(1.0)), 100.0},
          {"very far", test::mono_rig(test::long_focus()), test::target_of(test::cube(1.0)), 900.0},
          {"small", test::mono_rig(test::pinhole()), test::target_of(small), 0.05},
          {"two cameras", two, test::target_of(test::square(0.5)), 5.0}};
}

PoseObservations seen_at(const Setting& s, const Pose& truth, test::Normal& rng) {
  PoseObservations seen = test::see_all(s.rig, s.target, truth, 1.0, rng, 0.5);
  for (std::size_t i = 0; i < seen.size(); ++i) seen[i].sigma_px = i % 3 == 0 ? 1.0 : 0.5;
  return seen;
}

/// Turned by up to 10 deg, a twentieth of the range away.
Pose off_by_a_bit(const Pose& pose, test::Normal& rng) {
  const double angle = 10.0 / degrees_per_radian * rng.generator().uniform();
  return {reference_dcm(rng.vec3(), angle) * pose.R_CT,
          pose.t_CT + 0.05 * pose.t_CT.norm() * (rng.generator().uniform() - 0.5) * Vec3::UnitZ()};
}

Pose some_pose(const Setting& s, test::Normal& rng) {
  if (s.rig.size() == 2) return {reference_dcm(rng.vec3(), 0.6), Vec3(0.3, 0.0, s.range)};
  return {test::random_attitude(rng), s.range * Vec3(0.01, -0.01, 1.0)};
}

struct Agreement {
  double largest = 0.0;  ///< difference from the optimum over sigma
  int failures = 0;
  int most_iterations = 0;
};

template <typename S>
Agreement agreement_of(const Setting& s, std::uint64_t seed) {
  test::Normal rng(seed);
  Agreement a;
  for (int i = 0; i < 300; ++i) {
    const Pose truth = some_pose(s, rng);
    const PoseObservations seen = seen_at(s, truth, rng);
    PoseEstimate e;
    const Status status =
        solve_scaled_pose<S>(s.rig, s.target, seen, test::all_used(), off_by_a_bit(truth, rng), {}, e);
    if (status != Status::ok) {
      ++a.failures;
      continue;
    }
    const Pose optimum = test::reference_optimum(s.rig, s.target, seen, truth);
    const Vec6 d = test::pose_difference(e.pose, optimum);
    a.largest = std::max(a.largest, std::sqrt(test::mahalanobis_squared(d, e.covariance)));
    a.most_iterations = std::max(a.most_iterations, e.iterations);
  }
  return a;
}

}  // namespace

TEST_GROUP(ScaledPoseSolver){};

namespace {

/// Of the cost after a step [dt 2dg].
double half_cost(const ScaledRows<double>& rows, GibbsSet<double> attitude, Vec3 t, const Vec6& step) {
  attitude.correct(0.5 * step.tail<3>());
  t += step.head<3>();
  PoseRow<double> row;
  double sum = 0.0;
  for (int i = 0; i < rows.count(); ++i) {
    CHECK(rows(i, attitude.dcm(), t, row) == Status::ok);
    sum += 0.5 * row.r.squaredNorm();
  }
  return sum;
}

TEST(ScaledPoseSolver, curvature_is_the_hessian_less_that_of_gauss_newton) {
  const Setting s = settings()[5];  // two cameras, one turned
  test::Normal rng(6);
  double worst = 0.0;
  double least_share = 1.0;
  for (int trial = 0; trial < 50; ++trial) {
    const Pose truth = some_pose(s, rng);
    const Pose start = off_by_a_bit(truth, rng);
    ScaledRows<double> rows;
    CHECK(rows.gather(s.rig, s.target, seen_at(s, truth, rng), test::all_used(), start) == Status::ok);
    const RodriguesChart chart = RodriguesChart::from_dcm(start.R_CT);
    const GibbsSet<double> attitude{chart.parameters(), chart.set_index()};
    const Vec3 t = start.t_CT / rows.length();
    Mat6 gauss_newton = Mat6::Zero();
    Mat6 curvature = Mat6::Zero();
    for (int i = 0; i < rows.count(); ++i) {
      PoseRow<double> row;
      CHECK(rows(i, attitude.dcm(), t, row) == Status::ok);
      Mat<3, 6> D;
      D << Mat3::Identity(), cross_matrix(row.X_r);
      const Mat<2, 6> A = row.J * D;
      gauss_newton += A.transpose() * A;
      add_curvature(row, curvature);
    }
    constexpr double h = 1e-3;
    Mat6 hessian;
    for (int a = 0; a < 6; ++a) {
      for (int b = 0; b < 6; ++b) {
        const auto at = [&](double along_a, double along_b) {
          return half_cost(rows, attitude, t, along_a * Vec6::Unit(a) + along_b * Vec6::Unit(b));
        };
        hessian(a, b) = (at(h, h) - at(h, -h) - at(-h, h) + at(-h, -h)) / (4.0 * h * h);
      }
    }
    worst = std::max(worst, (gauss_newton + curvature - hessian).norm() / hessian.norm());
    least_share = std::min(least_share, curvature.norm() / hessian.norm());
  }
  std::printf("    Hessian: off by %.1e; curvature is %.1e of it at least\n", worst, least_share);
  CHECK(worst < 1e-5);
  CHECK(least_share > 1e-3);
}

TEST(ScaledPoseSolver, every_arithmetic_comes_to_the_optimum) {
  for (const Setting& s : settings()) {
    const Agreement in_double = agreement_of<double>(s, 1);
    const Agreement in_float = agreement_of<float>(s, 1);
    const Agreement in_fixed = agreement_of<FixedQ47>(s, 1);
    std::printf("    %-12s off by sigmas, iterations: double %.1e, %d; float %.1e, %d; Q16.47 %.1e, %d\n", s.name,
                in_double.largest, in_double.most_iterations, in_float.largest, in_float.most_iterations,
                in_fixed.largest, in_fixed.most_iterations);
    // What distortion bends within a residual of a pixel.
    const double bent = s.rig[s.rig.size() - 1].model.intrinsics().model == DistortionModel::none ? 0.0 : 2e-3;
    CHECK_TEXT(in_double.largest < 1e-6 + bent, s.name);
    CHECK_TEXT(in_float.largest < 1e-3 + bent, s.name);
    CHECK_TEXT(in_fixed.largest < 1e-6 + bent, s.name);
    for (const Agreement& a : {in_double, in_float, in_fixed}) {
      LONGS_EQUAL_TEXT(0, a.failures, s.name);
      CHECK_TEXT(a.most_iterations <= 20, s.name);
    }
  }
}

struct Sweep {
  int failures = 0;
  int other_minimum = 0;  ///< than double's
  double largest = 0.0;   ///< distance to double's over sigma, elsewhere
};

/// Ranges from 1 to 200 m, evenly by their logarithm; attitudes evenly over SO(3), every fourth a turn by exactly 180 deg;
/// 1 px. near: starts off by up to 10 deg and a twentieth of the range; else by anything and 0.7 to 1.4 times the range.
template <typename S>
Sweep sweep(const CameraIntrinsics& camera, bool near, int count) {
  test::Normal rng(7);
  const CameraRig rig = test::mono_rig(camera);
  const double field = 1000.0 / camera.fu;  // tan of half the field of view, about
  Sweep result;
  for (int i = 0; i < count; ++i) {
    const double range = std::pow(200.0, rng.generator().uniform());
    // Through a wide lens always the same target; through a long one such that all of it is in view.
    const double radius = field > 0.5 ? 0.4 : range * field * (0.1 + 0.7 * rng.generator().uniform());
    const TargetModel target = test::target_of(test::cube(radius / std::sqrt(3.0)));
    const Mat3 R_CT = i % 4 == 3 ? test::random_half_turn(rng) : test::random_attitude(rng);
    const Vec2 beside = 0.002 * rng.vec2();
    const Pose truth{R_CT, range * Vec3(beside.x(), beside.y(), 1.0)};
    const PoseObservations seen = test::see_all(rig, target, truth, 1.0, rng);
    Pose start = off_by_a_bit(truth, rng);
    if (!near) start = {test::random_attitude(rng), (0.7 + 0.7 * rng.generator().uniform()) * truth.t_CT};
    PoseEstimate e;
    PoseEstimate expected;
    const Status status = solve_scaled_pose<S>(rig, target, seen, test::all_used(), start, {}, e);
    CHECK(solve_scaled_pose<double>(rig, target, seen, test::all_used(), start, {}, expected) == Status::ok);
    if (status != Status::ok) {
      ++result.failures;
      continue;
    }
    const Vec6 d = test::pose_difference(e.pose, expected.pose);
    const double sigmas = std::sqrt(test::mahalanobis_squared(d, expected.covariance));
    if (sigmas > 0.5 && !near) {
      ++result.other_minimum;
    } else {
      result.largest = std::max(result.largest, sigmas);
    }
  }
  return result;
}

TEST(ScaledPoseSolver, no_overflow_from_1_to_200_m_at_any_attitude) {
  for (const CameraIntrinsics& camera : {test::long_focus(), test::pinhole()}) {
    for (const bool near : {true, false}) {
      const Sweep fixed = sweep<FixedQ47>(camera, near, near ? poses : poses / 5);
      const Sweep single = sweep<float>(camera, near, poses / 5);
      std::printf("    f = %.0f px, %s: Q16.47 %d failures, %.1e sigma, %d elsewhere; float %d, %.1e, %d\n", camera.fu,
                  near ? "near starts" : "any start", fixed.failures, fixed.largest, fixed.other_minimum,
                  single.failures, single.largest, single.other_minimum);
      LONGS_EQUAL(0, fixed.failures);
      LONGS_EQUAL(0, single.failures);
      CHECK(fixed.largest < 1e-5);
      CHECK(single.largest < 2e-3);
      LONGS_EQUAL(0, fixed.other_minimum);
      LONGS_EQUAL(0, single.other_minimum);
    }
  }
}

TEST(ScaledPoseSolver, no_overflow_where_two_minima_merge) {
  // A square face on, the start between its two tilts: curvature and first derivatives cancel, pivots vanish.
  test::Normal rng(7);
  const TargetModel target = test::target_of(test::square(0.5));
  const CameraRig rigs[] = {test::mono_rig(test::long_focus()), test::mono_rig(test::pinhole())};
  const double least[] = {20.0, 2.0};
  const double most[] = {200.0, 30.0};
  int other = 0;
  constexpr int count = 4 * poses / 5;
  for (int i = 0; i < 2 * count; ++i) {
    const CameraRig& rig = rigs[i % 2];
    const double z = least[i % 2] + (most[i % 2] - least[i % 2]) * i / (2.0 * count);
    const Pose truth{Mat3::Identity(), Vec3(0.0, 0.0, z)};
    const PoseObservations seen = test::see_all(rig, target, truth, 1.0, rng, i % 4 < 2 ? 1.0 : 0.0);
    Pose start = truth;
    if (i % 3 != 0) {
      const double angle = (i % 3 == 1 ? 0.01 : 0.3) * rng();
      start.R_CT = reference_dcm(rng.vec3(), angle);
    }
    PoseEstimate e;
    PoseEstimate expected;
    CHECK(solve_scaled_pose<FixedQ47>(rig, target, seen, test::all_used(), start, {}, e) == Status::ok);
    CHECK(solve_scaled_pose<double>(rig, target, seen, test::all_used(), start, {}, expected) == Status::ok);
    const Vec6 d = test::pose_difference(e.pose, expected.pose);
    other += test::mahalanobis_squared(d, expected.covariance) > 0.25 ? 1 : 0;
  }
  std::printf("    face on: %d of %d in the other minimum than double\n", other, 2 * count);
  CHECK(other < 40);
}

/// A target that turns by 0.4 deg an epoch through 180 deg, each epoch started from the one before.
struct HalfTurn {
  int lost_near = 0;  ///< where |g| > 256
  int lost_elsewhere = 0;
  Status last_failure = Status::ok;
};

template <typename S>
HalfTurn half_turn(bool switching) {
  const Setting s = settings()[2];
  test::Normal rng(2);
  PoseSolverSettings solver;
  solver.switching = switching;
  HalfTurn result;
  const Vec3 axis(0.3, 0.4, 0.866);
  for (double angle_deg = 100.1; angle_deg < 260.0; angle_deg += 0.4) {
    const Pose truth{reference_dcm(axis, angle_deg / degrees_per_radian), Vec3(0.1, 0.2, s.range)};
    const Pose before{reference_dcm(axis, (angle_deg - 0.4) / degrees_per_radian), Vec3(0.1, 0.2, s.range)};
    PoseEstimate e;
    const Status status =
        solve_scaled_pose<S>(s.rig, s.target, seen_at(s, truth, rng), test::all_used(), before, solver, e);
    if (status == Status::ok) {
      CHECK(test::rotation_angle(e.pose.R_CT, truth.R_CT) < 0.5 / degrees_per_radian);
      continue;
    }
    // tan(theta / 2) = 256 at 0.448 deg from 180 deg; the start is half a degree behind.
    ++(std::abs(angle_deg - 180.0) < 0.9 ? result.lost_near : result.lost_elsewhere);
    result.last_failure = status;
  }
  return result;
}

TEST(ScaledPoseSolver, half_a_turn_is_lost_in_fixed_point_without_switching_only) {
  for (const HalfTurn& h : {half_turn<double>(true), half_turn<float>(true), half_turn<FixedQ47>(true),
                            half_turn<double>(false), half_turn<float>(false)}) {
    LONGS_EQUAL(0, h.lost_near);
    LONGS_EQUAL(0, h.lost_elsewhere);
  }
  const HalfTurn h = half_turn<FixedQ47>(false);
  std::printf("    Q16.47 without switching: %d epochs lost within 0.9 deg of half a turn\n", h.lost_near);
  CHECK(h.lost_near >= 2);
  LONGS_EQUAL(0, h.lost_elsewhere);
  CHECK(h.last_failure == Status::not_finite);
}

TEST(ScaledPoseSolver, exactly_half_a_turn_has_no_rodrigues_parameters) {
  const Setting s = settings()[0];
  test::Normal rng(3);
  const Pose truth{Vec3(1.0, -1.0, -1.0).asDiagonal(), Vec3(0.0, 0.0, s.range)};
  const PoseObservations seen = seen_at(s, truth, rng);
  PoseSolverSettings solver;
  PoseEstimate e;
  for (const bool switching : {true, false}) {
    solver.switching = switching;
    const Status expected = switching ? Status::ok : Status::not_finite;
    CHECK(solve_scaled_pose<double>(s.rig, s.target, seen, test::all_used(), truth, solver, e) == expected);
    CHECK(solve_scaled_pose<float>(s.rig, s.target, seen, test::all_used(), truth, solver, e) == expected);
    CHECK(solve_scaled_pose<FixedQ47>(s.rig, s.target, seen, test::all_used(), truth, solver, e) == expected);
  }
}

TEST(ScaledPoseSolver, chi_square_and_covariance_are_those_of_the_result) {
  const Setting s = settings()[1];
  test::Normal rng(4);
  const Pose truth = some_pose(s, rng);
  const PoseObservations seen = seen_at(s, truth, rng);
  PoseEstimate e;
  CHECK(solve_scaled_pose<FixedQ47>(s.rig, s.target, seen, test::all_used(), truth, {}, e) == Status::ok);
  const double chi2 = test::residuals(s.rig, s.target, seen, e.pose).squaredNorm();
  DOUBLES_EQUAL(chi2, e.chi2, 1e-9 * chi2);
  const Mat6 bound = test::pose_bound(s.rig, s.target, seen, e.pose);
  for (int k = 0; k < 6; ++k) DOUBLES_EQUAL(bound(k, k), e.covariance(k, k), 1e-6 * bound(k, k));
  LONGS_EQUAL(8, e.used);
  LONGS_EQUAL(10, e.degrees_of_freedom);
}

template <typename S>
void check_refusals() {
  const Setting s = settings()[0];
  test::Normal rng(5);
  const Pose truth = some_pose(s, rng);
  const PoseObservations seen = seen_at(s, truth, rng);
  ObservationMask used = test::all_used();
  PoseEstimate e;
  e.iterations = -1;
  const auto status_of = [&](const TargetModel& target, const PoseObservations& observations, const Pose& start) {
    return solve_scaled_pose<S>(s.rig, target, observations, used, start, {}, e);
  };
  PoseObservations bad = seen;
  bad[3].camera = 1;
  CHECK(status_of(s.target, bad, truth) == Status::invalid_argument);
  bad = seen;
  bad[3].feature = 8;
  CHECK(status_of(s.target, bad, truth) == Status::invalid_argument);
  bad = seen;
  bad[3].sigma_px = 0.0;
  CHECK(status_of(s.target, bad, truth) == Status::invalid_argument);
  Pose start = truth;
  start.t_CT.x() = std::nan("");
  CHECK(status_of(s.target, seen, start) == Status::invalid_argument);
  start = truth;
  start.t_CT.z() = 0.1;
  CHECK(status_of(s.target, seen, start) == Status::behind_camera);
  const TargetModel line = test::target_of({Vec3(0, 0, 0), Vec3(0.1, 0, 0), Vec3(0.3, 0, 0), Vec3(-0.2, 0, 0)});
  CHECK(status_of(line, test::see_all(s.rig, line, truth, 1.0, rng), truth) == Status::rank_deficient);
  const TargetModel point = test::target_of({Vec3::Zero(), Vec3::Zero(), Vec3::Zero()});
  CHECK(status_of(point, test::see_all(s.rig, point, truth, 1.0, rng), truth) == Status::rank_deficient);
  used.fill(false);
  CHECK(status_of(s.target, seen, truth) == Status::too_few_features);
  used[0] = used[1] = true;
  CHECK(status_of(s.target, seen, truth) == Status::too_few_features);
  LONGS_EQUAL(-1, e.iterations);  // untouched
}

TEST(ScaledPoseSolver, says_what_is_missing) {
  check_refusals<double>();
  check_refusals<float>();
  check_refusals<FixedQ47>();
}

}  // namespace
}  // namespace relnav
