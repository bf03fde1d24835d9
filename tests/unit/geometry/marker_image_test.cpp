#include "fsw/geometry/marker_image.hpp"

#include "tests/support/numeric_jacobian.hpp"

#include <CppUTest/TestHarness.h>

namespace relnav {
namespace {

RigCamera second_camera() {
  CameraIntrinsics k;
  k.fu = k.fv = 700.0;
  k.cu = 512.0;
  k.cv = 384.0;
  k.width_px = 1024;
  k.height_px = 768;
  k.model = DistortionModel::radial_tangential;
  k.coefficients = {-0.1, 0.02, 0.001, -0.001};
  RigCamera camera;
  camera.model = CameraModel::create(k).value();
  camera.R_KC = exp_so3(Vec3(0.01, -0.1, 0.02));
  camera.t_KC = Vec3(-0.4, 0.01, 0.02);
  return camera;
}

const Vec3 p_T(0.3, -0.2, 0.1);
const Pose pose{exp_so3(Vec3(0.4, 1.0, -0.3)), Vec3(0.2, 0.1, 5.0)};

}  // namespace

TEST_GROUP(MarkerImage){};

TEST(MarkerImage, is_the_cameras_image_of_the_moved_point) {
  const RigCamera camera = second_camera();
  MarkerImage image;
  CHECK(image_of(camera, p_T, pose, image) == Status::ok);
  Vec2 expected_px;
  const Vec3 p_C = pose.R_CT * p_T + pose.t_CT;
  CHECK(camera.model.project(camera.R_KC * p_C + camera.t_KC, expected_px) == Status::ok);
  CHECK((image.uv_px - expected_px).norm() < 1e-12);
}

TEST(MarkerImage, jacobian_equals_the_numeric_one) {
  const RigCamera camera = second_camera();
  MarkerImage image;
  CHECK(image_of(camera, p_T, pose, image) == Status::ok);
  const auto moved = [&](const Vec6& d) {
    MarkerImage there;
    CHECK(image_of(camera, p_T, {exp_so3(Vec3(d.tail<3>())) * pose.R_CT, pose.t_CT + d.head<3>()}, there) ==
          Status::ok);
    return there.uv_px;
  };
  CHECK(test::jacobian_error(image.J, moved, Vec6(Vec6::Zero()), 1e-5) < 1e-7);
}

TEST(MarkerImage, a_point_behind_the_camera_has_none) {
  MarkerImage image;
  CHECK(image_of(second_camera(), p_T, {pose.R_CT, Vec3(0.0, 0.0, -5.0)}, image) == Status::behind_camera);
}

}  // namespace relnav
