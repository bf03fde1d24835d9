#include "fsw/estimation/measurement_model.hpp"

#include <cmath>

#include "fsw/estimation/inverse_depth.hpp"
#include "tests/support/dense.hpp"
#include "tests/support/numeric_jacobian.hpp"
#include "tests/unit/estimation/estimation_samples.hpp"

#include <CppUTest/TestHarness.h>

namespace relnav {
namespace {

const RigidTargetMotion rigid_target;
const CameraMotion moving_camera;

/// A feature (inverse depth or Euclidean) that the camera sees from the given pose, a few metres before it.
Feature seen_feature(test::Samples& samples, const PoseLinearisation& pose, int size) {
  const Vec3 p_C = samples.within({-1.5, -1.0, 3.0}, {1.5, 1.0, 6.0});
  const Vec3 X_T = pose.R_CT.transpose() * (p_C - pose.t_CT);
  Feature f;
  f.size = size;
  f.offset = 12;
  f.y.setZero();
  if (size == 3) {
    f.y.head<3>() = X_T;
  } else {
    f.y.head<3>() = samples.matrix<3>(2.0);  // anchor
    const Vec3 ray = X_T - f.y.head<3>();
    Mat23 ignored;
    inverse_depth::angles_of(ray, f.y(3), f.y(4), ignored);
    f.y(5) = 1.0 / ray.norm();
  }
  return f;
}

template <typename Check>
void for_each_view(const Check& check) {
  test::Samples samples(21);
  for (const MotionModel* model :
       {static_cast<const MotionModel*>(&rigid_target), static_cast<const MotionModel*>(&moving_camera)}) {
    for (const AttitudeChartKind chart : test::both_charts) {
      for (const int size : {6, 3}) {
        for (const double angle : test::attitude_angles) {
          for (int i = 0; i < 4; ++i) {
            const MotionState motion = samples.motion(chart, angle);
            check(*model, motion, seen_feature(samples, model->pose(motion), size));
          }
        }
      }
    }
  }
}

}  // namespace

TEST_GROUP(MeasurementModel){};

TEST(MeasurementModel, pixel_is_the_projected_point) {
  const CameraModel camera = test::sample_camera();
  for_each_view([&](const MotionModel& model, const MotionState& motion, const Feature& f) {
    const PoseLinearisation pose = model.pose(motion);
    Mat<3, 6> ignored;
    const Vec3 X_T = f.size == 3 ? Vec3(f.y.head<3>()) : inverse_depth::point_T(f.y, ignored);
    Vec2 expected;
    Vec2 uv;
    CHECK(camera.project(pose.R_CT * X_T + pose.t_CT, expected) == Status::ok);
    CHECK(predict_pixel(camera, pose, f, uv) == Status::ok);
    CHECK((uv - expected).norm() < 1e-9);
  });
}

TEST(MeasurementModel, jacobian_is_that_of_the_pixel) {
  const CameraModel camera = test::sample_camera();
  int views = 0;
  for_each_view([&](const MotionModel& model, const MotionState& motion, const Feature& f) {
    const PoseLinearisation pose = model.pose(motion);
    PredictedImage image;
    CHECK(predict_image(camera, pose, f, image) == Status::ok);
    LONGS_EQUAL(f.offset, image.H.feature_offset);
    LONGS_EQUAL(f.size, image.H.feature_size);
    const auto pixel = [&](const Mat<18>& dx) -> Vec2 {
      Feature moved_feature = f;
      moved_feature.y += dx.tail<6>();
      Vec2 uv(NAN, NAN);
      const Status status = predict_pixel(camera, model.pose(test::moved(motion, dx.head<12>())), moved_feature, uv);
      return status == Status::ok ? uv : Vec2(NAN, NAN);
    };
    Mat<2, 18> H;
    for (int r = 0; r < 2; ++r) {
      for (int k = 0; k < 12; ++k) H(r, k) = image.H.motion[r][k];
      for (int k = 0; k < 6; ++k) H(r, 12 + k) = image.H.feature[r][k];
    }
    CHECK((test::jacobian_error<2, 18>(H, pixel, Mat<18>::Zero(), 1e-5) < 1e-6));
    Vec2 uv;
    CHECK(predict_pixel(camera, pose, f, uv) == Status::ok);
    CHECK(uv == image.uv_px);
    ++views;
  });
  CHECK_EQUAL(2 * 2 * 2 * 7 * 4, views);
}

TEST(MeasurementModel, a_feature_at_infinity_has_an_image_and_one_behind_has_none) {
  const CameraModel camera = test::sample_camera();
  const PoseLinearisation pose;
  Feature f;
  f.y << 0.0, 0.0, 0.0, 0.1, 0.1, 0.0;
  PredictedImage image;
  CHECK(predict_image(camera, pose, f, image) == Status::ok);
  CHECK(image.uv_px.allFinite());
  f.y(3) = 3.0;
  CHECK(predict_image(camera, pose, f, image) == Status::behind_camera);
}

TEST(MeasurementModel, image_covariance_is_the_dense_product) {
  const CameraModel camera = test::sample_camera();
  test::Samples samples(23);
  FilterState state;
  const MotionState motion = samples.motion(AttitudeChartKind::rodrigues, 0.4);
  state.reset(motion, samples.covariance<12>());
  const PoseLinearisation pose = rigid_target.pose(motion);
  for (int i = 0; i < 5; ++i) {
    CHECK(state.add(seen_feature(samples, pose, 6), samples.matrix<6, 12>(), {}, samples.covariance<6>()).has_value());
  }
  state.make_euclidean(2);
  for (const Feature& f : state.features()) {
    PredictedImage image;
    CHECK(predict_image(camera, pose, f, image) == Status::ok);
    const Eigen::MatrixXd H = test::dense_rows(image.H, state.size());
    const Eigen::MatrixXd expected = test::congruence(H, test::dense_covariance(state));
    CHECK(test::matrix_difference(image_covariance(state, image.H), expected) < 1e-12);
  }
}

}  // namespace relnav
