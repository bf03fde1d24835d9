#include "fsw/attitude/so3.hpp"

#include <Eigen/Geometry>
#include <cmath>

#include "fsw/math/elementary.hpp"
#include "tests/support/numeric_jacobian.hpp"
#include "tests/unit/attitude/attitude_samples.hpp"

#include <CppUTest/TestHarness.h>

namespace relnav {

using test::max_difference;

TEST_GROUP(So3){};

TEST(So3, cross_matrix_multiplies_as_the_cross_product) {
  const Vec3 a(1.0, -2.0, 3.5);
  const Vec3 b(-0.3, 0.7, 2.0);
  CHECK((cross_matrix(a) * b - a.cross(b)).norm() < 1e-15);
}

TEST(So3, positive_turn_about_z_takes_x_to_y) {
  CHECK((exp_so3(Vec3(0.0, 0.0, pi / 2)) * Vec3::UnitX() - Vec3::UnitY()).norm() < 1e-15);
}

TEST(So3, exponential_equals_the_long_double_reference) {
  for (const auto& sample : test::rotation_samples()) {
    CHECK_TRUE_TEXT(max_difference(exp_so3(sample.rotation_vector()), sample.dcm()) < 2e-15, sample.name.c_str());
  }
}

TEST(So3, logarithm_inverts_the_exponential_up_to_180_degrees) {
  for (const auto& sample : test::rotation_samples()) {
    const Vec3 phi = sample.rotation_vector();
    if (std::fabs(sample.angle) > test::pi_l - 0.9e-9L) continue;
    CHECK_TRUE_TEXT((log_so3(sample.dcm()) - phi).norm() < 4e-15 * (0.1 + phi.norm()), sample.name.c_str());
  }
}

TEST(So3, exponential_inverts_the_logarithm_everywhere_and_the_angle_stays_within_180_degrees) {
  for (const auto& sample : test::rotation_samples()) {
    const Vec3 phi = log_so3(sample.dcm());
    CHECK_TRUE_TEXT(phi.norm() <= pi * (1.0 + 1e-15), sample.name.c_str());
    CHECK_TRUE_TEXT(max_difference(exp_so3(phi), sample.dcm()) < 3e-15, sample.name.c_str());
  }
}

TEST(So3, logarithm_of_exactly_180_degrees) {
  const Mat3 about_y = Vec3(-1.0, 1.0, -1.0).asDiagonal();
  CHECK((log_so3(about_y).cwiseAbs() - Vec3(0.0, pi, 0.0)).norm() < 1e-15);
  Mat3 about_xy;
  about_xy << 0, 1, 0, 1, 0, 0, 0, 0, -1;
  CHECK((log_so3(about_xy).cwiseAbs() - Vec3(pi, pi, 0.0) / std::sqrt(2.0)).norm() < 1e-15);
}

TEST(So3, small_rotations_keep_their_relative_accuracy) {
  for (const double angle : {1e-100, 1e-12, 1e-8, 1e-4}) {
    const Vec3 phi(angle, -2.0 * angle, 0.5 * angle);
    CHECK((log_so3(exp_so3(phi)) - phi).norm() < 4e-16 * phi.norm());
  }
}

TEST(So3, left_and_right_jacobian_equal_the_numeric_ones) {
  for (const auto& sample : test::rotation_samples()) {
    const Vec3 phi = sample.rotation_vector();
    const Mat3 R = exp_so3(phi);
    const auto left = [&](const Vec3& d) { return log_so3(exp_so3(phi + d) * R.transpose()); };
    const auto right = [&](const Vec3& d) { return log_so3(R.transpose() * exp_so3(phi + d)); };
    const Vec3 zero = Vec3::Zero();
    CHECK_TRUE_TEXT(test::jacobian_error(left_jacobian_so3(phi), left, zero, 1e-5) < 1e-9, sample.name.c_str());
    CHECK_TRUE_TEXT(test::jacobian_error(right_jacobian_so3(phi), right, zero, 1e-5) < 1e-9, sample.name.c_str());
  }
}

TEST(So3, left_jacobian_is_rotation_times_right_jacobian) {
  for (const auto& sample : test::rotation_samples()) {
    const Vec3 phi = sample.rotation_vector();
    CHECK_TRUE_TEXT(max_difference(left_jacobian_so3(phi), exp_so3(phi) * right_jacobian_so3(phi)) < 3e-15,
                    sample.name.c_str());
  }
}

TEST(So3, orthonormalise_finds_the_polar_factor) {
  Generator generator(11);
  for (int i = 0; i < 200; ++i) {
    const Mat3 R = exp_so3(test::random_vector(generator, 3.0));
    Mat3 stretch = Mat3::Identity();
    const Vec3 a = test::random_vector(generator, 0.1);
    stretch += 2.0 * (a * a.transpose()) - 0.02 * Mat3::Identity();  // symmetric, positive definite
    const Mat3 result = orthonormalise(R * stretch);
    CHECK(max_difference(result, R) < 2e-15);
    CHECK(max_difference(result.transpose() * result, Mat3::Identity()) < 2e-15);
  }
  // At the edge of its domain.
  CHECK(max_difference(orthonormalise(1.2 * Mat3::Identity()), Mat3::Identity()) < 1e-15);
  CHECK(max_difference(orthonormalise(0.72 * Mat3::Identity()), Mat3::Identity()) < 1e-15);
}

TEST(So3, angles_beyond_the_domain_and_nan_give_nan) {
  CHECK(std::isnan(exp_so3(Vec3(0.0, 2.1 * math::max_angle, 0.0))(0, 0)));
  CHECK(std::isnan(exp_so3(Vec3(0.0, std::nan(""), 0.0))(0, 0)));
  CHECK(std::isnan(log_so3(Mat3::Constant(std::nan("")))(0)));
}

}  // namespace relnav
