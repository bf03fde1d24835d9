#include "fsw/attitude/quaternion.hpp"

#include <cmath>

#include "fsw/attitude/so3.hpp"
#include "tests/unit/attitude/attitude_samples.hpp"

#include <CppUTest/TestHarness.h>

namespace relnav {

using test::max_difference;

TEST_GROUP(Quaternion){};

TEST(Quaternion, product_is_hamiltons) {
  const Quaternion i{1, 0, 0, 0};
  const Quaternion j{0, 1, 0, 0};
  const Quaternion k = multiply(i, j);
  DOUBLES_EQUAL(1.0, k.z, 0.0);
  DOUBLES_EQUAL(-1.0, multiply(k, k).w, 0.0);
  DOUBLES_EQUAL(-1.0, multiply(j, i).z, 0.0);
}

TEST(Quaternion, round_trip_through_the_dcm_is_unit_with_w_not_negative) {
  for (const auto& sample : test::rotation_samples()) {
    const Quaternion q = Quaternion::from_dcm(sample.dcm());
    CHECK_TRUE_TEXT(q.w >= 0.0, sample.name.c_str());
    CHECK_TRUE_TEXT(std::fabs(q.squared_norm() - 1.0) < 1e-15, sample.name.c_str());
    CHECK_TRUE_TEXT(max_difference(q.dcm(), sample.dcm()) < 2e-15, sample.name.c_str());
  }
}

TEST(Quaternion, from_rotation_vector_equals_the_reference_with_its_sign) {
  for (const auto& sample : test::rotation_samples()) {
    const Quaternion q = Quaternion::from_rotation_vector(sample.rotation_vector());
    const Vec3 v = static_cast<double>(std::sin(sample.angle / 2)) * sample.axis.normalized();
    CHECK_TRUE_TEXT((q.vector() - v).norm() < 1.5e-15, sample.name.c_str());
    CHECK_TRUE_TEXT(std::fabs(q.w - static_cast<double>(std::cos(sample.angle / 2))) < 1.5e-15, sample.name.c_str());
  }
}

TEST(Quaternion, product_composes_rotations) {
  Generator generator(5);
  for (int i = 0; i < 1000; ++i) {
    const Vec3 a = test::random_vector(generator, 3.0);
    const Vec3 b = test::random_vector(generator, 3.0);
    const Quaternion q = multiply(Quaternion::from_rotation_vector(a), Quaternion::from_rotation_vector(b));
    CHECK(max_difference(q.dcm(), exp_so3(a) * exp_so3(b)) < 3e-15);
  }
}

TEST(Quaternion, conjugate_is_the_inverse_and_both_signs_are_one_rotation) {
  const Quaternion q = Quaternion::from_rotation_vector(Vec3(0.4, -1.0, 2.0));
  CHECK(max_difference(q.conjugate().dcm(), q.dcm().transpose()) < 1e-16);
  const Quaternion minus{-q.x, -q.y, -q.z, -q.w};
  CHECK(max_difference(minus.dcm(), q.dcm()) < 1e-16);
  CHECK((minus.rotation_vector() - q.rotation_vector()).norm() < 1e-15);
  CHECK(minus.canonical().w >= 0.0 && q.canonical().w >= 0.0);
}

TEST(Quaternion, normalised_keeps_the_direction_over_its_domain) {
  for (const double scale : {1e-150, 0.3, 7.0, 1e150}) {
    const Quaternion q = Quaternion{0.5 * scale, -0.5 * scale, 0.5 * scale, -0.5 * scale}.normalised();
    CHECK((q.vector() - Vec3(0.5, -0.5, 0.5)).norm() < 1e-15);
    DOUBLES_EQUAL(-0.5, q.w, 1e-15);
  }
}

TEST(Quaternion, dcm_need_not_be_exactly_orthonormal) {
  Generator generator(6);
  for (const auto& sample : test::rotation_samples()) {
    Mat3 noise;
    for (int c = 0; c < 3; ++c) noise.col(c) = test::random_vector(generator, 1e-3);
    const Quaternion q = Quaternion::from_dcm(sample.dcm() + noise);
    CHECK_TRUE_TEXT(max_difference(q.dcm(), sample.dcm()) < 4e-3, sample.name.c_str());
    CHECK_TRUE_TEXT(std::fabs(q.squared_norm() - 1.0) < 1e-15, sample.name.c_str());
  }
}

}  // namespace relnav
