// Triangulation, motor and orthogonal method: exact without noise, as accurate as cooperative-stereo.md says with it.
#include "fsw/estimation/stereo_closed_form.hpp"

#include <cmath>
#include <cstdio>

#include "fsw/estimation/pose_least_squares.hpp"
#include "tests/unit/estimation/pose_samples.hpp"

#include <CppUTest/TestHarness.h>

namespace relnav {
namespace {

using test::degrees_per_radian;

#ifdef __SANITIZE_ADDRESS__
constexpr int poses = 400;
#else
constexpr int poses = 4000;
#endif

/// f = 35 mm, 4256 x 2832 px on 36.0 x 23.9 mm: the paper's.
CameraIntrinsics paper_camera() {
  CameraIntrinsics k;
  k.fu = 35.0 * 4256.0 / 36.0;
  k.fv = 35.0 * 2832.0 / 23.9;
  k.cu = 2127.5;
  k.cv = 1415.5;
  k.width_px = 4256;
  k.height_px = 2832;
  return k;
}

CameraRig paper_rig() {
  return test::stereo_rig(paper_camera(), paper_camera(), Mat3::Identity(), Vec3(1.0, 0.0, 0.0));
}

/// Any relative orientation, lens distortion.
CameraRig general_rig() {
  const Mat3 R_10 = test::reference_dcm(Vec3(0.1, -1.0, 0.2), 0.3) * test::reference_dcm(Vec3(0, 0, 1), 2.0);
  return test::stereo_rig(test::distorted(DistortionModel::radial_tangential),
                          test::distorted(DistortionModel::equidistant), R_10, Vec3(-1.0, 0.2, 0.1));
}

Pose some_pose(test::Normal& rng, double range, double middle_x) {
  Pose pose;
  const Vec3 tilt = 0.5 * rng.vec3();
  pose.R_CT = test::reference_dcm(tilt, tilt.norm());
  pose.t_CT = Vec3(middle_x, 0.0, range) + 0.2 * rng.vec3();
  return pose;
}

StereoPoints points_of(const CameraRig& rig, const TargetModel& target, const PoseObservations& seen) {
  StereoPoints points;
  CHECK(triangulate_features(rig, target, seen, points) == Status::ok);
  return points;
}

TEST_GROUP(StereoClosedForm){};

TEST(StereoClosedForm, every_method_is_exact_without_noise) {
  test::Normal rng(1);
  double triangulated = 0.0;
  double motor = 0.0;
  double orthogonal = 0.0;
  for (int i = 0; i < 200; ++i) {
    const CameraRig rig = i % 2 == 0 ? paper_rig() : general_rig();
    TargetModel target = test::target_of(i % 4 < 2 ? test::square(0.5) : test::cube(0.3));
    const Pose truth = some_pose(rng, 5.0, i % 2 == 0 ? 0.5 : -0.3);
    const StereoPoints points = points_of(rig, target, test::see_all(rig, target, truth, 1.0, rng, 0.0));
    LONGS_EQUAL(static_cast<int>(target.features.size()), static_cast<int>(points.p_C.size()));
    for (std::size_t k = 0; k < points.p_C.size(); ++k) {
      const Vec3 p_C = truth.R_CT * points.p_T[k] + truth.t_CT;
      triangulated = std::max(triangulated, (points.p_C[k] - p_C).norm());
    }
    Pose pose;
    for (const MotorLines lines : {MotorLines::target, MotorLines::all}) {
      CHECK(solve_motor(target, points, lines, pose) == Status::ok);
      motor = std::max(motor, test::pose_difference(truth, pose).norm());
    }
    for (const auto& [from, to] : {std::pair{0, 1}, std::pair{3, 1}, std::pair{2, 3}}) {
      CHECK(target.lines.push_back({static_cast<std::uint16_t>(from), static_cast<std::uint16_t>(to)}) == Status::ok);
    }
    CHECK(solve_motor(target, points, MotorLines::target, pose) == Status::ok);
    motor = std::max(motor, test::pose_difference(truth, pose).norm());
    CHECK(solve_orthogonal(points, pose) == Status::ok);
    orthogonal = std::max(orthogonal, test::pose_difference(truth, pose).norm());
  }
  std::printf("    exact images: triangulation %.1e m, motor %.1e, orthogonal %.1e\n", triangulated, motor, orthogonal);
  CHECK(triangulated < 1e-11);
  CHECK(motor < 1e-11);
  CHECK(orthogonal < 1e-11);
}

TEST(StereoClosedForm, off_centre_the_motor_is_exact_and_the_orthogonal_method_wrong_by_the_offset) {
  test::Normal rng(2);
  const CameraRig rig = paper_rig();
  const Vec3 middle(1.0, -0.5, 2.0);
  const TargetModel target = test::target_of(test::square(0.5, middle));
  for (int i = 0; i < 50; ++i) {
    Pose truth = some_pose(rng, 6.0, 0.5);
    truth.t_CT -= truth.R_CT * middle;
    const StereoPoints points = points_of(rig, target, test::see_all(rig, target, truth, 1.0, rng, 0.0));
    Pose pose;
    for (const MotorLines lines : {MotorLines::target, MotorLines::all}) {
      CHECK(solve_motor(target, points, lines, pose) == Status::ok);
      CHECK(test::pose_difference(truth, pose).norm() < 1e-11);
    }
    CHECK(solve_orthogonal(points, pose) == Status::ok);
    CHECK(test::rotation_angle(truth.R_CT, pose.R_CT) < 1e-11);
    DOUBLES_EQUAL(middle.norm(), (pose.t_CT - truth.t_CT).norm(), 1e-11);
  }
}

struct Accuracy {
  Vec6 error2 = Vec6::Zero();
  double attitude2 = 0.0;
  void add(const Pose& estimate, const Pose& truth) {
    const Vec6 e = test::pose_difference(estimate, truth);
    error2 += e.cwiseAbs2() / poses;
    attitude2 += e.tail<3>().squaredNorm() / poses;
  }
  Vec6 print(const char* name, const Vec6& bound2) const {
    const Vec6 ratio = error2.cwiseQuotient(bound2).cwiseSqrt();
    std::printf("    %-16s RMS/CRLB %.2f %.2f %.2f, %.2f %.2f %.2f; attitude %.2f deg\n", name, ratio(0), ratio(1),
                ratio(2), ratio(3), ratio(4), ratio(5), std::sqrt(attitude2) * degrees_per_radian);
    return ratio;
  }
};

TEST(StereoClosedForm, accuracy_is_that_of_the_specification) {
  test::Normal rng(3);
  const CameraRig rig = paper_rig();
  const TargetModel target = test::target_of(test::square(0.5));
  Accuracy motor;
  Accuracy motor_all;
  Accuracy orthogonal;
  Accuracy refined;
  Vec6 bound2 = Vec6::Zero();
  double nees = 0.0;
  for (int i = 0; i < poses; ++i) {
    // Range 10 to 5 m, the target in the middle between the cameras, turned by up to 25 deg an axis.
    Pose truth;
    const double range = 10.0 - 5.0 * i / poses;
    Vec3 tilt(0, 0, 0);
    for (int k = 0; k < 3; ++k) tilt(k) = (rng.generator().uniform() - 0.5) * 2.0 * 25.0 / degrees_per_radian;
    truth.R_CT = test::reference_dcm(tilt, tilt.norm());
    truth.t_CT = Vec3(0.5, 0.0, range);
    const PoseObservations seen = test::see_all(rig, target, truth, 1.0, rng);
    const StereoPoints points = points_of(rig, target, seen);
    Pose start;
    Pose pose;
    CHECK(solve_motor(target, points, MotorLines::target, start) == Status::ok);
    motor.add(start, truth);
    CHECK(solve_motor(target, points, MotorLines::all, pose) == Status::ok);
    motor_all.add(pose, truth);
    CHECK(solve_orthogonal(points, pose) == Status::ok);
    orthogonal.add(pose, truth);
    PoseEstimate e;
    CHECK(solve_pose(rig, target, seen, test::all_used(), start, {}, e) == Status::ok);
    refined.add(e.pose, truth);
    const Vec6 error = test::pose_difference(e.pose, truth);
    nees += error.dot(e.covariance.ldlt().solve(error)) / poses;
    bound2 += test::pose_bound(rig, target, seen, truth).diagonal() / poses;
  }
  const Vec6 m = motor.print("motor, 3 lines", bound2);
  const Vec6 a = motor_all.print("motor, all lines", bound2);
  const Vec6 o = orthogonal.print("orthogonal", bound2);
  const Vec6 ml = refined.print("refined", bound2);
  std::printf("    refined: NEES %.3f\n", nees);
  CHECK(ml.maxCoeff() < 1.05);
  CHECK(ml.minCoeff() > 0.95);
  CHECK(nees > 5.8 && nees < 6.2);
  // The specification's table: motor 4.7 5.3 1.3, 4.5 4.7 3.2, 2.81 deg; orthogonal 1.2 1.2 1.3, 3.7 3.7 2.3, 2.28 deg. Its
  // attitudes are not printed; across the line of sight ours is better, as lines are of unit length.
  const auto within = [](const Vec6& ratio, const Vec6& low, const Vec6& high) {
    return (ratio.array() > low.array()).all() && (ratio.array() < high.array()).all();
  };
  Vec6 low;
  Vec6 high;
  low << 2.5, 2.5, 1.1, 3.4, 3.4, 3.0;
  high << 4.7, 5.3, 1.4, 4.8, 4.8, 4.5;
  CHECK(within(m, low, high));
  low << 1.1, 1.1, 1.1, 2.8, 2.8, 2.2;
  high << 1.3, 1.3, 1.4, 4.0, 4.0, 3.2;
  CHECK(within(o, low, high));
  CHECK((a.tail<3>() - o.tail<3>()).cwiseAbs().maxCoeff() < 0.1);  // with all lines the same attitude
  DOUBLES_EQUAL(2.81, std::sqrt(motor.attitude2) * degrees_per_radian, 0.3);
  DOUBLES_EQUAL(2.28, std::sqrt(orthogonal.attitude2) * degrees_per_radian, 0.3);
  DOUBLES_EQUAL(0.74, std::sqrt(refined.attitude2) * degrees_per_radian, 0.08);
}

TEST(StereoClosedForm, refinement_has_an_answer_face_on_too) {
  // Where the two minima of a plane merge, first derivatives converge slowly or overshoot: once 1 in 100 had no answer.
  test::Normal rng(7);
  const CameraRig rig = paper_rig();
  const TargetModel target = test::target_of(test::square(0.5));
  int most_iterations = 0;
  for (int i = 0; i < poses; ++i) {
    const Pose truth{Mat3::Identity(), Vec3(0.5, 0.0, 10.0 - 5.0 * i / poses)};
    const PoseObservations seen = test::see_all(rig, target, truth, 1.0, rng);
    Pose start;
    CHECK(solve_motor(target, points_of(rig, target, seen), MotorLines::target, start) == Status::ok);
    PoseEstimate e;
    CHECK(solve_pose(rig, target, seen, test::all_used(), start, {}, e) == Status::ok);
    most_iterations = std::max(most_iterations, e.iterations);
  }
  std::printf("    face on: at most %d iterations\n", most_iterations);
}

TEST(StereoClosedForm, says_what_is_missing) {
  test::Normal rng(4);
  const CameraRig rig = paper_rig();
  const TargetModel target = test::target_of(test::square(0.5));
  const Pose truth = some_pose(rng, 6.0, 0.5);
  const PoseObservations seen = test::see_all(rig, target, truth, 1.0, rng);
  StereoPoints points;
  CHECK(triangulate_features(test::mono_rig(paper_camera()), target, seen, points) == Status::invalid_argument);
  PoseObservations bad = seen;
  bad[5].camera = 2;
  CHECK(triangulate_features(rig, target, bad, points) == Status::invalid_argument);
  bad = seen;
  bad[5].feature = 4;
  CHECK(triangulate_features(rig, target, bad, points) == Status::invalid_argument);
  bad = seen;
  bad[5].uv_px.x() = HUGE_VAL;
  CHECK(triangulate_features(rig, target, bad, points) != Status::ok);

  // Two features in both cameras, the others in one only.
  bad.clear();
  for (std::size_t f = 0; f < 4; ++f) {
    CHECK(test::see(rig, target, truth, 0, f, 1.0, rng, bad));
    if (f < 2) CHECK(test::see(rig, target, truth, 1, f, 1.0, rng, bad));
  }
  CHECK(triangulate_features(rig, target, bad, points) == Status::ok);
  LONGS_EQUAL(2, static_cast<int>(points.p_C.size()));
  Pose pose;
  CHECK(solve_motor(target, points, MotorLines::target, pose) == Status::too_few_features);
  CHECK(solve_orthogonal(points, pose) == Status::too_few_features);
}

TEST(StereoClosedForm, a_point_with_parallel_or_diverging_rays_is_left_out) {
  test::Normal rng(5);
  const CameraRig rig = paper_rig();
  const TargetModel target = test::target_of(test::square(0.5));
  PoseObservations seen = test::see_all(rig, target, some_pose(rng, 6.0, 0.5), 1.0, rng);
  seen[5].uv_px = seen[1].uv_px;                     // infinitely far
  seen[6].uv_px = seen[2].uv_px + Vec2(100.0, 0.0);  // they meet behind the cameras
  StereoPoints points;
  CHECK(triangulate_features(rig, target, seen, points) == Status::ok);
  LONGS_EQUAL(2, static_cast<int>(points.p_C.size()));
  LONGS_EQUAL(0, points.feature[0]);
  LONGS_EQUAL(3, points.feature[1]);
}

TEST(StereoClosedForm, parallel_lines_and_points_on_a_line_are_rank_deficient) {
  test::Normal rng(6);
  for (int i = 0; i < 200; ++i) {
    const CameraRig rig = i % 2 == 0 ? paper_rig() : general_rig();
    const Pose truth = some_pose(rng, 6.0, i % 2 == 0 ? 0.5 : -0.3);
    Pose pose;
    // The target's own lines: two opposite edges of the square.
    TargetModel target = test::target_of(test::square(0.5));
    CHECK(target.lines.push_back({0, 1}) == Status::ok);
    CHECK(target.lines.push_back({2, 3}) == Status::ok);
    const StereoPoints corners = points_of(rig, target, test::see_all(rig, target, truth, 1.0, rng, 0.0));
    CHECK(solve_motor(target, corners, MotorLines::target, pose) == Status::rank_deficient);
    CHECK(solve_motor(target, corners, MotorLines::all, pose) == Status::ok);

    const Vec3 at = 0.2 * rng.vec3();
    const Vec3 along = 0.2 * rng.vec3();
    const TargetModel line = test::target_of({at, at + along, at - along, at + 0.3 * along});
    const StereoPoints on_line = points_of(rig, line, test::see_all(rig, line, truth, 1.0, rng, 0.0));
    CHECK(solve_motor(line, on_line, MotorLines::target, pose) == Status::rank_deficient);
    CHECK(solve_motor(line, on_line, MotorLines::all, pose) == Status::rank_deficient);
    CHECK(solve_orthogonal(on_line, pose) == Status::rank_deficient);
  }
}

}  // namespace
}  // namespace relnav
