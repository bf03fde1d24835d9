#include "fsw/geometry/camera_model.hpp"

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "fsw/base/generator.hpp"
#include "tests/support/numeric_jacobian.hpp"

#include <CppUTest/TestHarness.h>

namespace relnav {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();

CameraIntrinsics intrinsics(DistortionModel model, std::array<double, 4> coefficients, double focal = 700.0) {
  CameraIntrinsics k;
  k.fu = focal;
  k.fv = 1.01 * focal;
  k.cu = 510.0;
  k.cv = 380.0;
  k.width_px = 1024;
  k.height_px = 768;
  k.model = model;
  k.coefficients = coefficients;
  return k;
}

struct NamedCamera {
  std::string name;
  CameraIntrinsics intrinsics;
};

// All cover their image.
std::vector<NamedCamera> cameras() {
  using enum DistortionModel;
  CameraIntrinsics telephoto = intrinsics(none, {});
  telephoto.fu = telephoto.fv = 200e-3 / 7e-6;
  telephoto.width_px = telephoto.height_px = 2048;
  telephoto.cu = telephoto.cv = 1023.5;
  return {
      {"none", intrinsics(none, {})},
      {"telephoto of the paper", telephoto},
      {"radial_tangential, zero", intrinsics(radial_tangential, {})},
      {"radial_tangential, barrel", intrinsics(radial_tangential, {-0.28, 0.07, 0.0002, 0.00002})},
      {"radial_tangential, pincushion", intrinsics(radial_tangential, {0.5, 0.3, 0.01, -0.01})},
      {"radial_tangential, strongly decentred", intrinsics(radial_tangential, {-0.28, 0.07, 0.01, -0.02})},
      {"radial_inverse, barrel", intrinsics(radial_inverse, {0.2, 0.1})},
      {"radial_inverse, pincushion", intrinsics(radial_inverse, {-0.2, 0.02})},
      {"equidistant, zero", intrinsics(equidistant, {})},
      {"equidistant", intrinsics(equidistant, {-0.012, 0.021, -0.0054, 0.0011})},
      {"equidistant, beyond 90 deg", intrinsics(equidistant, {-0.01, 0.003, -0.0005, 0.00001}, 300.0)},
      {"equidistant, to 160 deg", intrinsics(equidistant, {}, 230.0)},
      {"equidistant, narrow", intrinsics(equidistant, {-0.012, 0.021, -0.0054, 0.0011}, 5000.0)},
  };
}

CameraModel made(const CameraIntrinsics& k) {
  const auto camera = CameraModel::create(k);
  CHECK_TRUE_TEXT(camera.has_value(), to_string(camera.status()));
  return camera.value();
}

// A grid over the whole image, its outermost edges included.
std::vector<Vec2> image_grid(const CameraIntrinsics& k, int steps) {
  std::vector<Vec2> pixels;
  for (int i = 0; i <= steps; ++i) {
    for (int j = 0; j <= steps; ++j) {
      pixels.emplace_back(-0.5 + k.width_px * double(i) / steps, -0.5 + k.height_px * double(j) / steps);
    }
  }
  pixels.emplace_back(k.cu, k.cv);
  pixels.emplace_back(k.cu + 1e-9, k.cv);
  pixels.emplace_back(k.cu, k.cv - 1e-5);
  return pixels;
}

// The status, and that the outputs were left alone on an error.
Status project(const CameraModel& camera, const Vec3& p_C) {
  Vec2 uv_px(123.0, 456.0);
  Mat23 J = Mat23::Constant(7.0);
  const Status status = camera.project(p_C, uv_px, J);
  if (status != Status::ok) CHECK(uv_px == Vec2(123.0, 456.0) && J == Mat23(Mat23::Constant(7.0)));
  Vec2 again;
  CHECK(camera.project(p_C, again) == status);
  return status;
}

Status unproject(const CameraModel& camera, const Vec2& uv_px) {
  Vec3 ray_C(1.0, 2.0, 3.0);
  Mat<3, 2> J = Mat<3, 2>::Constant(7.0);
  const Status status = camera.unproject(uv_px, ray_C, J);
  if (status != Status::ok) CHECK(ray_C == Vec3(1.0, 2.0, 3.0) && J == (Mat<3, 2>(Mat<3, 2>::Constant(7.0))));
  Vec3 again;
  CHECK(camera.unproject(uv_px, again) == status);
  return status;
}

}  // namespace

TEST_GROUP(CameraModel){};

namespace {

TEST(CameraModel, every_pixel_goes_out_and_comes_back) {
  for (const auto& [name, k] : cameras()) {
    const CameraModel camera = made(k);
    CHECK_TRUE_TEXT(camera.covers_image(), name.c_str());
    for (const Vec2& uv_px : image_grid(k, 40)) {
      Vec3 ray_C;
      Vec2 back_px;
      CHECK_TRUE_TEXT(camera.unproject(uv_px, ray_C) == Status::ok, name.c_str());
      CHECK_TRUE_TEXT(camera.project(3.7 * ray_C, back_px) == Status::ok, name.c_str());
      CHECK_TRUE_TEXT((back_px - uv_px).norm() < 2e-12 * 1024, name.c_str());
      if (k.model == DistortionModel::equidistant) {
        CHECK_TRUE_TEXT(std::fabs(ray_C.norm() - 1.0) < 1e-15, name.c_str());
      } else {
        DOUBLES_EQUAL(1.0, ray_C.z(), 0.0);
      }
    }
  }
}

TEST(CameraModel, jacobian_of_project_equals_the_numeric_one) {
  for (const auto& [name, k] : cameras()) {
    const CameraModel camera = made(k);
    const auto pixel = [&](const Vec3& p_C) {
      Vec2 uv_px = Vec2::Constant(nan);
      const Status status = camera.project(p_C, uv_px);
      return status == Status::ok ? uv_px : Vec2(Vec2::Constant(nan));
    };
    for (const Vec2& uv_px : image_grid(k, 12)) {
      Vec3 ray_C;
      CHECK(camera.unproject(uv_px, ray_C) == Status::ok);
      const Vec3 p_C = 2.5 * ray_C;
      Vec2 unused;
      Mat23 J;
      CHECK(camera.project(p_C, unused, J) == Status::ok);
      CHECK_TRUE_TEXT(test::jacobian_error(J, pixel, p_C, 1e-5) < 1e-8, name.c_str());
      // Only the direction of p_C matters.
      CHECK_TRUE_TEXT((J * p_C).norm() < 1e-12 * J.norm() * p_C.norm(), name.c_str());
    }
  }
}

TEST(CameraModel, jacobian_of_unproject_equals_the_numeric_one_and_inverts_that_of_project) {
  for (const auto& [name, k] : cameras()) {
    const CameraModel camera = made(k);
    const auto ray = [&](const Vec2& uv_px) {
      Vec3 ray_C;
      const Status status = camera.unproject(uv_px, ray_C);
      return status == Status::ok ? ray_C : Vec3(Vec3::Constant(nan));
    };
    for (const Vec2& uv_px : image_grid(k, 12)) {
      Vec3 ray_C;
      Mat<3, 2> J_ray_uv;
      Vec2 unused;
      Mat23 J_uv_p;
      CHECK(camera.unproject(uv_px, ray_C, J_ray_uv) == Status::ok);
      CHECK(camera.project(ray_C, unused, J_uv_p) == Status::ok);
      // In units of a focal length, so that the tolerance means something.
      const Mat<3, 2> scaled = k.fu * J_ray_uv;
      const auto scaled_ray = [&](const Vec2& d) { return ray(uv_px + k.fu * d); };
      const Vec2 zero = Vec2::Zero();
      CHECK_TRUE_TEXT(test::jacobian_error(scaled, scaled_ray, zero, 1e-6) < 3e-8, name.c_str());
      CHECK_TRUE_TEXT((J_uv_p * J_ray_uv - Mat2::Identity()).norm() < 1e-11, name.c_str());
    }
  }
}

struct Projection {
  Vec3 p_C;
  Vec2 uv_px;
};

// Values of cv::projectPoints, OpenCV 4.6.0 (Debian 12), rvec = tvec = 0, printed with %.17g.
TEST(CameraModel, radial_tangential_equals_opencv) {
  CameraIntrinsics k = intrinsics(DistortionModel::radial_tangential, {-0.28, 0.07, 0.0015, -0.002});
  k.fv = 705.0;
  const CameraModel camera = made(k);
  const std::vector<Projection> expected = {
      {Vec3(0.3, -0.2, 1), Vec2(712.04442999999992, 244.35687199999998)},
      {Vec3(-1.1, 0.7, 2), Vec2(164.10090624999998, 601.75797031249999)},
      {Vec3(2, 1.5, 4), Vec2(824.60402832031252, 618.4645718383789)},
      {Vec3(-0.5, -0.35, 0.9), Vec2(164.37510520923303, 137.27466676510187)},
      {Vec3(0.01, 0.02, 5), Vec2(511.3999697600392, 382.82001663807898)},
      {Vec3(0, 0, 3), Vec2(510, 380)},
  };
  for (const auto& [p_C, uv_px] : expected) {
    Vec2 actual_px;
    CHECK(camera.project(p_C, actual_px) == Status::ok);
    CHECK((actual_px - uv_px).norm() < 1e-12 * 1024);
  }
  // d uv / d tvec at the first point, the same program.
  Mat23 expected_J;
  expected_J << 639.42129999999997, 23.181200000000004, -187.19014999999996,  //
      23.346779999999999, 663.29149500000005, 125.65426500000002;
  Vec2 uv_px;
  Mat23 J;
  CHECK(camera.project(expected[0].p_C, uv_px, J) == Status::ok);
  CHECK((J - expected_J).norm() < 1e-11);
}

// Values of cv::fisheye::projectPoints, made likewise.
TEST(CameraModel, equidistant_equals_opencv_fisheye) {
  CameraIntrinsics k = intrinsics(DistortionModel::equidistant, {-0.012, 0.021, -0.0054, 0.0011});
  k.fu = 350.0;
  k.fv = 352.0;
  const CameraModel camera = made(k);
  const std::vector<Projection> expected = {
      {Vec3(0.3, -0.2, 1), Vec2(610.65958104656283, 312.51014756497119)},
      {Vec3(-1.1, 0.7, 2), Vec2(339.72488891189369, 488.97607109638801)},
      {Vec3(2, 1.5, 4), Vec2(666.11792691645576, 497.75752201698378)},
      {Vec3(-0.5, -0.35, 0.9), Vec2(339.44941285478689, 259.93238664976997)},
      {Vec3(0.01, 0.02, 5), Vec2(510.69999516539855, 381.40799027554453)},
      {Vec3(0, 0, 3), Vec2(510, 380)},
  };
  for (const auto& [p_C, uv_px] : expected) {
    Vec2 actual_px;
    CHECK(camera.project(p_C, actual_px) == Status::ok);
    CHECK((actual_px - uv_px).norm() < 1e-12 * 1024);
  }
  Mat23 expected_J;
  expected_J << 317.05716015751943, 12.3165177762379, -92.653844492008233,  //
      12.386897877816383, 329.19133025659983, 62.122196687975048;
  Vec2 uv_px;
  Mat23 J;
  CHECK(camera.project(expected[0].p_C, uv_px, J) == Status::ok);
  CHECK((J - expected_J).norm() < 1e-11);
}

TEST(CameraModel, radial_inverse_undistorts_by_its_polynomial) {
  const CameraIntrinsics k = intrinsics(DistortionModel::radial_inverse, {0.2, 0.1});
  const CameraModel camera = made(k);
  const Vec2 d(0.4, -0.3);  // r_d = 0.5
  Vec3 ray_C;
  CHECK(camera.unproject(Vec2(k.cu + k.fu * d.x(), k.cv + k.fv * d.y()), ray_C) == Status::ok);
  const double factor = 1.0 + 0.2 * 0.25 + 0.1 * 0.0625;
  CHECK((ray_C - Vec3(factor * d.x(), factor * d.y(), 1.0)).norm() < 1e-15);
}

TEST(CameraModel, without_distortion_it_is_the_pinhole) {
  const CameraIntrinsics k = intrinsics(DistortionModel::none, {9.0, 9.0, 9.0, 9.0});
  const CameraModel camera = made(k);
  Vec2 uv_px;
  CHECK(camera.project(Vec3(1.0, -2.0, 4.0), uv_px) == Status::ok);
  CHECK((uv_px - Vec2(k.fu * 0.25 + k.cu, -k.fv * 0.5 + k.cv)).norm() < 1e-12);
  CHECK(camera.domain_limit() == infinity);
  // A point far outside the image still projects.
  CHECK(camera.project(Vec3(1000.0, 0.0, 1.0), uv_px) == Status::ok);
}

TEST(CameraModel, points_behind_the_camera_have_no_image) {
  for (const auto& [name, k] : cameras()) {
    const CameraModel camera = made(k);
    for (const Vec3& p_C : {Vec3(0.0, 0.0, -1.0), Vec3(1e-9, 0.0, -1.0), Vec3(0.01, -0.01, -1.0), Vec3(0.0, 0.0, 0.0),
                            Vec3(0.0, 0.0, 1e-101)}) {
      CHECK_TRUE_TEXT(project(camera, p_C) == Status::behind_camera, name.c_str());
    }
    if (k.model == DistortionModel::equidistant) continue;
    for (const Vec3& p_C : {Vec3(1.0, 0.0, 0.0), Vec3(0.0, -1.0, 0.99e-6), Vec3(1.0, 2.0, -0.1)}) {
      CHECK_TRUE_TEXT(project(camera, p_C) == Status::behind_camera, name.c_str());
    }
  }
}

TEST(CameraModel, equidistant_sees_beyond_90_degrees) {
  CameraIntrinsics k = intrinsics(DistortionModel::equidistant, {}, 300.0);
  k.fv = k.fu;
  const CameraModel camera = made(k);
  CHECK(camera.domain_limit() > 2.0);
  const double theta = 2.0;
  Vec2 uv_px;
  CHECK(camera.project(Vec3(std::sin(theta), 0.0, std::cos(theta)), uv_px) == Status::ok);
  CHECK((uv_px - Vec2(k.cu + k.fu * theta, k.cv)).norm() < 1e-11);
  Vec3 ray_C;
  CHECK(camera.unproject(uv_px, ray_C) == Status::ok);
  CHECK((ray_C - Vec3(std::sin(theta), 0.0, std::cos(theta))).norm() < 1e-14);
  // Outside the domain: named after the side on which the point lies.
  const double beyond = camera.domain_limit() + 1e-9;
  CHECK(project(camera, Vec3(0.0, std::sin(beyond), std::cos(beyond))) == Status::behind_camera);
  const CameraModel narrow = made(intrinsics(DistortionModel::equidistant, {}));
  CHECK(project(narrow, Vec3(1.0, 0.0, 0.05)) == Status::outside_domain);
}

TEST(CameraModel, only_the_direction_of_a_point_matters) {
  for (const auto& [name, k] : cameras()) {
    const CameraModel camera = made(k);
    Vec3 p_C;
    CHECK(camera.unproject(Vec2(700.0, 250.0), p_C) == Status::ok);
    Vec2 expected_px;
    CHECK(camera.project(p_C, expected_px) == Status::ok);
    for (const double scale : {1e-99, 1e-9, 1e9, 1e200}) {
      Vec2 uv_px;
      CHECK_TRUE_TEXT(camera.project(scale * p_C, uv_px) == Status::ok, name.c_str());
      CHECK_TRUE_TEXT((uv_px - expected_px).norm() < 1e-12 * 1024, name.c_str());
    }
  }
}

TEST(CameraModel, domain_ends_where_the_distortion_would_turn_back) {
  // d = r (1 - 0.4 r^2): slope 1 - 1.2 r^2 reaches 0.02 at r = sqrt(0.98 / 1.2), where d = 0.549; the corner is at 0.92.
  const CameraIntrinsics k = intrinsics(DistortionModel::radial_tangential, {-0.4, 0.0, 0.0, 0.0});
  const CameraModel camera = made(k);
  const double limit = std::sqrt(0.98 / 1.2);
  DOUBLES_EQUAL(limit, camera.domain_limit(), 1e-12);
  CHECK_FALSE(camera.covers_image());
  CHECK(project(camera, Vec3(0.0, limit - 1e-9, 1.0)) == Status::ok);
  CHECK(project(camera, Vec3(0.0, limit + 1e-9, 1.0)) == Status::outside_domain);
  // Without the limit this point would fold back onto the middle of the image.
  CHECK(project(camera, Vec3(1.55, 0.0, 1.0)) == Status::outside_domain);
  const double d_limit = limit * (1.0 - 0.4 * limit * limit);
  CHECK(unproject(camera, Vec2(k.cu + k.fu * (d_limit - 1e-9), k.cv)) == Status::ok);
  CHECK(unproject(camera, Vec2(k.cu + k.fu * (d_limit + 1e-9), k.cv)) == Status::outside_domain);
  CHECK(unproject(camera, Vec2(0.0, 0.0)) == Status::outside_domain);

  // The same polynomial the other way round, and of the angle.
  const CameraModel inverse = made(intrinsics(DistortionModel::radial_inverse, {-0.4, 0.0}));
  DOUBLES_EQUAL(limit, inverse.domain_limit(), 1e-12);
  CHECK_FALSE(inverse.covers_image());
  CHECK(unproject(inverse, Vec2(k.cu + k.fu * (limit - 1e-9), k.cv)) == Status::ok);
  CHECK(unproject(inverse, Vec2(k.cu + k.fu * (limit + 1e-9), k.cv)) == Status::outside_domain);
  CHECK(project(inverse, Vec3(d_limit - 1e-9, 0.0, 1.0)) == Status::ok);
  CHECK(project(inverse, Vec3(d_limit + 1e-9, 0.0, 1.0)) == Status::outside_domain);

  const CameraModel angle = made(intrinsics(DistortionModel::equidistant, {-0.4, 0.0, 0.0, 0.0}));
  DOUBLES_EQUAL(limit, angle.domain_limit(), 1e-12);
  CHECK(project(angle, Vec3(std::sin(limit - 1e-9), 0.0, std::cos(limit - 1e-9))) == Status::ok);
  CHECK(project(angle, Vec3(std::sin(limit + 1e-9), 0.0, std::cos(limit + 1e-9))) == Status::outside_domain);
  CHECK(unproject(angle, Vec2(k.cu + k.fu * (d_limit - 1e-9), k.cv)) == Status::ok);
  CHECK(unproject(angle, Vec2(k.cu + k.fu * (d_limit + 1e-9), k.cv)) == Status::outside_domain);
}

TEST(CameraModel, domain_ends_25_percent_beyond_the_farthest_corner) {
  for (const auto& [name, k] : cameras()) {
    const bool decentred = k.model == DistortionModel::radial_tangential && k.coefficients[3] * k.coefficients[3] > 0.0;
    if (k.model == DistortionModel::none || decentred) continue;
    if (name.find(" deg") != std::string::npos) continue;  // end by 171 deg or by slope
    const CameraModel camera = made(k);
    const double reach = 1.25 * std::hypot((k.width_px - 0.5 - k.cu) / k.fu, (k.height_px - 0.5 - k.cv) / k.fv);
    CHECK_TRUE_TEXT(unproject(camera, Vec2(k.cu + k.fu * (reach - 1e-6), k.cv)) == Status::ok, name.c_str());
    CHECK_TRUE_TEXT(unproject(camera, Vec2(k.cu + k.fu * (reach + 1e-6), k.cv)) == Status::outside_domain,
                    name.c_str());
  }
}

TEST(CameraModel, random_calibrations_answer_right_or_say_no) {
  Generator generator(77);
  const auto uniform = [&](double size) { return size * (2.0 * generator.uniform() - 1.0); };
  int answered = 0;
  int refused = 0;
  for (int i = 0; i < 4000; ++i) {
    const auto model = static_cast<DistortionModel>(generator.below(4));
    const bool brown = model == DistortionModel::radial_tangential;
    // One draw a statement: the order of a call's arguments is each compiler's own.
    const double focal_length_px = 200.0 + 1500.0 * generator.uniform();
    CameraIntrinsics k = intrinsics(
        model, {uniform(0.6), uniform(0.4), uniform(brown ? 0.05 : 0.2), uniform(brown ? 0.05 : 0.1)}, focal_length_px);
    k.cu += uniform(300.0);
    k.cv += uniform(300.0);
    const CameraModel camera = made(k);
    const std::string name = "calibration " + std::to_string(i);
    for (int j = 0; j < 20; ++j) {
      Vec2 uv_px;
      uv_px.y() = 384.0 + uniform(1100.0);
      uv_px.x() = 512.0 + uniform(1500.0);
      const Status status = unproject(camera, uv_px);
      if (camera.in_image(uv_px) && camera.covers_image()) CHECK_TRUE_TEXT(status == Status::ok, name.c_str());
      if (status != Status::ok) {
        CHECK_TRUE_TEXT(status == Status::outside_domain, name.c_str());
        ++refused;
        continue;
      }
      ++answered;
      Vec3 ray_C;
      Vec2 back_px;
      CHECK(camera.unproject(uv_px, ray_C) == Status::ok);
      CHECK_TRUE_TEXT(camera.project(ray_C, back_px) == Status::ok, name.c_str());
      CHECK_TRUE_TEXT((back_px - uv_px).norm() < 1e-9, name.c_str());
    }
    for (int j = 0; j < 20; ++j) {
      Vec3 p_C;
      for (int c = 2; c >= 0; --c) p_C(c) = uniform(2.0);
      Vec2 uv_px;
      if (camera.project(p_C, uv_px) != Status::ok) {
        CHECK_TRUE_TEXT(project(camera, p_C) != Status::no_convergence, name.c_str());
        continue;
      }
      Vec3 ray_C;
      CHECK_TRUE_TEXT(camera.unproject(uv_px, ray_C) == Status::ok, name.c_str());
      CHECK_TRUE_TEXT((ray_C.normalized() - p_C.normalized()).norm() < 1e-11, name.c_str());
    }
  }
  CHECK(answered > 20000);
  CHECK(refused > 5000);
}

TEST(CameraModel, nan_and_infinity_are_refused) {
  for (const auto& [name, k] : cameras()) {
    const CameraModel camera = made(k);
    for (const double bad : {nan, infinity, -infinity}) {
      for (int i = 0; i < 3; ++i) {
        Vec3 p_C(0.1, 0.2, 1.0);
        p_C[i] = bad;
        CHECK_TRUE_TEXT(project(camera, p_C) == Status::not_finite, name.c_str());
      }
      CHECK_TRUE_TEXT(unproject(camera, Vec2(bad, 10.0)) == Status::not_finite, name.c_str());
      CHECK_TRUE_TEXT(unproject(camera, Vec2(10.0, bad)) == Status::not_finite, name.c_str());
    }
  }
}

TEST(CameraModel, create_refuses_what_is_not_a_camera) {
  const CameraIntrinsics good = intrinsics(DistortionModel::radial_tangential, {-0.2, 0.05, 0.0, 0.0});
  CHECK(CameraModel::create(good).has_value());
  DOUBLES_EQUAL(good.fu, made(good).intrinsics().fu, 0.0);
  const auto refused = [&](auto change) {
    CameraIntrinsics k = good;
    change(k);
    return CameraModel::create(k).status() == Status::invalid_argument;
  };
  for (const double bad : {nan, infinity, -infinity}) {
    CHECK(refused([&](auto& k) { k.fu = bad; }));
    CHECK(refused([&](auto& k) { k.fv = bad; }));
    CHECK(refused([&](auto& k) { k.cu = bad; }));
    CHECK(refused([&](auto& k) { k.cv = bad; }));
    CHECK(refused([&](auto& k) { k.coefficients[3] = bad; }));
  }
  CHECK(refused([](auto& k) { k.fu = 0.0; }));
  CHECK(refused([](auto& k) { k.fv = -700.0; }));
  CHECK(refused([](auto& k) { k.width_px = 0; }));
  CHECK(refused([](auto& k) { k.height_px = -1; }));
  CHECK(refused([](auto& k) { k.width_px = 65537; }));
  CHECK(refused([](auto& k) { k.height_px = 65537; }));
  CHECK(refused([](auto& k) { k.model = static_cast<DistortionModel>(9); }));
}

TEST(CameraModel, without_calibration_there_is_no_answer) {
  const CameraModel camera;
  CHECK(project(camera, Vec3(0.0, 0.0, 1.0)) == Status::not_configured);
  CHECK(unproject(camera, Vec2(0.0, 0.0)) == Status::not_configured);
  CHECK_FALSE(camera.covers_image());
}

TEST(CameraModel, image_reaches_half_a_pixel_beyond_the_outer_centres) {
  const CameraModel camera = made(intrinsics(DistortionModel::none, {}));
  CHECK(camera.in_image(Vec2(-0.5, -0.5)));
  CHECK(camera.in_image(Vec2(1023.5, 767.5)));
  CHECK_FALSE(camera.in_image(Vec2(-0.51, 5.0)));
  CHECK_FALSE(camera.in_image(Vec2(1023.51, 5.0)));
  CHECK_FALSE(camera.in_image(Vec2(5.0, -0.51)));
  CHECK_FALSE(camera.in_image(Vec2(5.0, 767.51)));
  CHECK_FALSE(camera.in_image(Vec2(9.0, 100.0), 10.0));
  CHECK(camera.in_image(Vec2(9.5, 100.0), 10.0));
  CHECK_FALSE(camera.in_image(Vec2(nan, 5.0)));
  CHECK_FALSE(camera.in_image(Vec2(5.0, nan)));
}

}  // namespace
}  // namespace relnav
