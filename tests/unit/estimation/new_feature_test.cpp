#include "fsw/estimation/new_feature.hpp"

#include <cmath>
#include <memory>

#include "fsw/estimation/inverse_depth.hpp"
#include "tests/support/numeric_jacobian.hpp"
#include "tests/unit/estimation/estimation_samples.hpp"

#include <CppUTest/TestHarness.h>

namespace relnav {
namespace {

const RigidTargetMotion rigid_target;
const CameraMotion moving_camera;
const NewFeatureSettings on_target{true, 4.0, 0.2, 0.1};

}  // namespace

TEST_GROUP(NewFeatures) {
  std::unique_ptr<FilterState> memory = std::make_unique<FilterState>();
  FilterState& state = *memory;
  test::Samples samples{81};
  const CameraModel camera = test::sample_camera();
  NewFeature fresh;

  /// A target four metres away with so many known features on it.
  void set_up_target(AttitudeChartKind chart, double angle_rad, int features, std::uint32_t found = 9) {
    MotionState motion = samples.motion(chart, angle_rad);
    motion.position = Vec3(0.1, -0.1, 4.0);
    state.reset(motion, samples.covariance<12>(0.1));
    const PoseLinearisation pose = rigid_target.pose(motion);
    for (int i = 0; i < features; ++i) {
      const Vec3 p_C = samples.within({-0.8, -0.6, 3.4}, {0.8, 0.6, 4.6});
      Feature f;
      f.y.head<3>() = pose.R_CT.transpose() * (Vec3(0.2, 0.1, -0.3) - pose.t_CT);
      const Vec3 ray = pose.R_CT.transpose() * (p_C - pose.t_CT) - f.y.head<3>();
      Mat23 ignored;
      inverse_depth::angles_of(ray, f.y(3), f.y(4), ignored);
      f.y(5) = 1.0 / ray.norm();
      f.found = found;
      CHECK(state.add(f, samples.matrix<6, 12>(0.1), {}, samples.covariance<6>(0.1)).has_value());
    }
    if (features > 2) state.make_euclidean(1);
  }
  Status make(const Vec2& uv_px, const MotionModel& model, const NewFeatureSettings& settings) {
    return make_new_feature(uv_px, camera, model.pose(state.motion), state, settings, fresh);
  }
};

TEST(NewFeatures, its_ray_is_that_of_the_pixel) {
  for (const MotionModel* model :
       {static_cast<const MotionModel*>(&rigid_target), static_cast<const MotionModel*>(&moving_camera)}) {
    for (const AttitudeChartKind chart : test::both_charts) {
      set_up_target(chart, 1.0, 6);
      for (const Vec2& uv_px : {Vec2(100.0, 80.0), Vec2(510.0, 385.0), Vec2(980.0, 700.0)}) {
        CHECK(make(uv_px, *model, on_target) == Status::ok);
        const PoseLinearisation pose = model->pose(state.motion);
        Mat<3, 6> ignored;
        Vec2 seen_px;
        CHECK(camera.project(pose.R_CT * inverse_depth::point_T(fresh.feature.y, ignored) + pose.t_CT, seen_px) ==
              Status::ok);
        CHECK((seen_px - uv_px).norm() < 1e-9);
        CHECK((fresh.feature.r_TC0 + pose.R_CT.transpose() * pose.t_CT).norm() < 1e-14);
        CHECK(fresh.feature.uv0_px == uv_px);
      }
    }
  }
}

TEST(NewFeatures, jacobians_are_those_of_the_block) {
  const Vec2 uv_px(560.0, 330.0);
  for (const AttitudeChartKind chart : test::both_charts) {
    for (const double angle : test::attitude_angles) {
      for (const int features : {0, 1, 3, 12}) {
        set_up_target(chart, angle, features);
        CHECK(make(uv_px, rigid_target, on_target) == Status::ok);
        const NewFeature at = fresh;
        LONGS_EQUAL(std::min(features, 4), at.depth_terms.size());
        const FilterState kept = state;
        const auto block = [&](const Mat<12>& dx) -> Vec6 {
          state.motion = test::moved(kept.motion, dx);
          CHECK(make(uv_px, rigid_target, on_target) == Status::ok);
          state.motion = kept.motion;
          return fresh.feature.y;
        };
        // Weights and choice of neighbours change with the pose as well; that is left out of the Jacobian, so rho's row is
        // compared with them held: by the total over one neighbour, and for more by its own test below.
        const Mat<6, 12> J = at.J_motion;
        const auto angles = [&](const Mat<12>& dx) -> Mat<5> { return block(dx).head<5>(); };
        const Mat<5, 12> J_angles = J.topRows<5>();
        CHECK((test::jacobian_error<5, 12>(J_angles, angles, Mat<12>::Zero(), 1e-5) < 1e-6));
        if (features > 1) continue;
        const auto rho = [&](const Mat<12>& dx) -> Mat<1> { return Mat<1>(block(dx)(5)); };
        const Mat<1, 12> J_rho = J.row(5);
        CHECK((test::jacobian_error<1, 12>(J_rho, rho, Mat<12>::Zero(), 1e-5) < 1e-6));
      }
    }
  }
}

TEST(NewFeatures, depth_goes_with_its_neighbours) {
  // All neighbours and the pose together: when everything is stretched along the line of sight, the new depth stretches.
  for (const AttitudeChartKind chart : test::both_charts) {
    set_up_target(chart, 0.7, 10);
    const Vec2 uv_px(500.0, 390.0);
    CHECK(make(uv_px, rigid_target, on_target) == Status::ok);
    const NewFeature at = fresh;
    const double kappa = 1e-6;
    const auto grown_by = [&](double factor) {
      FilterState grown = state;
      grown.motion.position *= factor;
      for (Feature& f : grown.features()) {
        f.y.head<3>() *= factor;
        if (f.size == 6) f.y(5) /= factor;
      }
      CHECK(make_new_feature(uv_px, camera, rigid_target.pose(grown.motion), grown, on_target, fresh) == Status::ok);
      return fresh.feature.y(5);
    };
    const double numeric = (grown_by(1.0 + kappa) - grown_by(1.0 - kappa)) / (2.0 * kappa);
    double analytic = at.J_motion.block<1, 3>(5, 0).dot(state.motion.position.transpose());
    for (const DepthTerm& term : at.depth_terms) {
      for (const Feature& f : state.features()) {
        if (f.offset != term.offset) continue;
        LONGS_EQUAL(f.size, term.size);
        Vec6 d = Vec6::Zero();
        d.head<3>() = f.y.head<3>();
        if (f.size == 6) d(5) = -f.y(5);
        analytic += term.J.head(f.size).dot(d.head(f.size));
      }
    }
    DOUBLES_EQUAL(-at.feature.y(5), analytic, 1e-9);
    DOUBLES_EQUAL(numeric, analytic, 1e-7);
  }
}

TEST(NewFeatures, one_neighbours_block_moves_it_as_its_term_says) {
  set_up_target(AttitudeChartKind::mrp, 0.7, 1);
  const Vec2 uv_px(500.0, 390.0);
  CHECK(make(uv_px, rigid_target, on_target) == Status::ok);
  const NewFeature at = fresh;
  LONGS_EQUAL(1, at.depth_terms.size());
  const Vec6 y = state.features()[0].y;
  const auto rho = [&](const Vec6& d) -> Mat<1> {
    state.features()[0].y = y + d;
    CHECK(make(uv_px, rigid_target, on_target) == Status::ok);
    return Mat<1>(fresh.feature.y(5));
  };
  const Mat<1, 6> J = at.depth_terms[0].J.transpose();
  CHECK((test::jacobian_error<1, 6>(J, rho, Vec6::Zero(), 1e-6) < 1e-7));
}

TEST(NewFeatures, nearer_neighbours_make_a_surer_depth) {
  set_up_target(AttitudeChartKind::mrp, 0.2, 1);
  const PoseLinearisation pose = rigid_target.pose(state.motion);
  Mat<3, 6> ignored;
  Vec2 neighbour_px;
  CHECK(camera.project(pose.R_CT * inverse_depth::point_T(state.features()[0].y, ignored) + pose.t_CT, neighbour_px) ==
        Status::ok);
  double before = 0.0;
  for (const double away_px : {0.0, 40.0, 120.0, 240.0}) {
    CHECK(make(neighbour_px + Vec2(-away_px, 0.0), rigid_target, on_target) == Status::ok);
    CHECK(fresh.noise(5, 5) > before);
    before = fresh.noise(5, 5);
  }
}

TEST(NewFeatures, unknown_neighbours_do_not_count) {
  set_up_target(AttitudeChartKind::mrp, 0.2, 5, 4);
  CHECK(make(Vec2(500.0, 390.0), rigid_target, on_target) == Status::ok);
  CHECK(fresh.depth_terms.empty());
  DOUBLES_EQUAL(1.0 / state.motion.position.norm(), fresh.feature.y(5), 1e-15);
  DOUBLES_EQUAL(on_target.relief * fresh.feature.y(5), std::sqrt(fresh.noise(5, 5)), 1e-15);
}

TEST(NewFeatures, an_unknown_scene_has_its_mean_depth) {
  const NewFeatureSettings scene{false, 2.0, 0.9, 0.25};
  state.reset(moving_camera.at_rest(AttitudeChartKind::mrp, Mat3::Identity(), Vec3::Zero()), Mat12::Identity());
  CHECK(make(Vec2(300.0, 200.0), moving_camera, scene) == Status::ok);
  DOUBLES_EQUAL(0.5, fresh.feature.y(5), 1e-15);  // nothing seen: the start range
  DOUBLES_EQUAL(0.45, std::sqrt(fresh.noise(5, 5)), 1e-15);
  for (int i = 0; i < 6; ++i) {
    Feature f;
    f.y << 0.0, 0.0, 0.0, 0.1 * i, 0.0, i == 0 ? -0.1 : 0.25;  // one beyond infinity: left out
    CHECK(state.add(f, Mat<6, 12>::Zero(), {}, Mat6::Identity()).has_value());
  }
  CHECK(make(Vec2(300.0, 200.0), moving_camera, scene) == Status::ok);
  CHECK(fresh.depth_terms.empty());
  DOUBLES_EQUAL(0.25, fresh.feature.y(5), 1e-12);
}

TEST(NewFeatures, noise_of_the_ray_is_that_of_the_first_view) {
  set_up_target(AttitudeChartKind::mrp, 0.9, 0);
  const Vec2 uv_px(700.0, 300.0);
  CHECK(make(uv_px, rigid_target, on_target) == Status::ok);
  const NewFeature at = fresh;
  const auto angles = [&](const Vec2& d) -> Vec2 {
    CHECK(make(uv_px + d, rigid_target, on_target) == Status::ok);
    return fresh.feature.y.segment<2>(3);
  };
  const Mat2 J = test::numeric_jacobian<2, 2>(angles, Vec2::Zero(), 1e-3);
  const Mat2 expected = 0.1 * 0.1 * J * J.transpose();
  CHECK((at.noise.block<2, 2>(3, 3) - expected).norm() < 1e-6 * expected.norm());
  CHECK((at.noise.block<3, 6>(0, 0).isZero(0.0)));
}

TEST(NewFeatures, a_pixel_without_a_ray_is_refused) {
  set_up_target(AttitudeChartKind::mrp, 0.9, 0);
  CHECK(make(Vec2(NAN, 0.0), rigid_target, on_target) != Status::ok);
  CHECK(make(Vec2(HUGE_VAL, 0.0), rigid_target, on_target) != Status::ok);
}

}  // namespace relnav
