#include "fsw/estimation/inverse_depth.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <limits>

#include "tests/support/numeric_jacobian.hpp"
#include "tests/unit/estimation/estimation_samples.hpp"

#include <CppUTest/TestHarness.h>

namespace relnav {
namespace {

template <typename Function>
void for_each_angle(const Function& f) {
  for (int i = -15; i <= 15; ++i) {
    for (int j = -7; j <= 7; ++j) f(0.2 * i, 0.2 * j);  // azimuth to +-3 rad, elevation to +-1.4 rad
  }
}

}  // namespace

TEST_GROUP(InverseDepth){};

TEST(InverseDepth, ray_is_a_unit_vector_of_eq_4) {
  for_each_angle([](double theta, double phi) {
    const Vec3 m = inverse_depth::ray_T(theta, phi);
    const Vec3 expected(std::cos(phi) * std::sin(theta), -std::sin(phi), std::cos(phi) * std::cos(theta));
    CHECK((m - expected).norm() < 1e-15);
    DOUBLES_EQUAL(1.0, m.norm(), 1e-15);
    Vec3 unused[2];
    CHECK(m == inverse_depth::ray_T(theta, phi, unused[0], unused[1]));
  });
}

TEST(InverseDepth, angles_of_a_ray_are_the_angles_it_was_made_of) {
  for_each_angle([](double theta, double phi) {
    for (const double length : {1e-3, 1.0, 250.0}) {
      double theta_back = 0.0;
      double phi_back = 0.0;
      Mat23 J;
      inverse_depth::angles_of(length * inverse_depth::ray_T(theta, phi), theta_back, phi_back, J);
      DOUBLES_EQUAL(theta, theta_back, 1e-14);
      DOUBLES_EQUAL(phi, phi_back, 1e-14);
    }
  });
}

TEST(InverseDepth, ray_derivatives_are_those_of_the_ray) {
  for_each_angle([](double theta, double phi) {
    Mat<3, 2> J;
    Vec3 dm_dtheta;
    Vec3 dm_dphi;
    static_cast<void>(inverse_depth::ray_T(theta, phi, dm_dtheta, dm_dphi));
    J << dm_dtheta, dm_dphi;
    const auto ray = [](const Vec2& a) -> Vec3 { return inverse_depth::ray_T(a(0), a(1)); };
    CHECK((test::jacobian_error<3, 2>(J, ray, Vec2(theta, phi)) < 1e-9));
  });
}

TEST(InverseDepth, angle_derivatives_are_those_of_the_angles) {
  for_each_angle([](double theta, double phi) {
    const Vec3 d = 2.5 * inverse_depth::ray_T(theta, phi);
    Mat23 J;
    double unused[2];
    inverse_depth::angles_of(d, unused[0], unused[1], J);
    const auto angles = [](const Vec3& v) -> Vec2 {
      Vec2 a;
      Mat23 ignored;
      inverse_depth::angles_of(v, a(0), a(1), ignored);
      return a;
    };
    CHECK((test::jacobian_error<2, 3>(J, angles, d, 1e-5) < 1e-8));
  });
}

TEST(InverseDepth, direction_along_y_has_an_elevation_and_a_zero_jacobian) {
  for (const double side : {1.0, -1.0}) {
    double theta = 7.0;
    double phi = 7.0;
    Mat23 J = Mat23::Ones();
    inverse_depth::angles_of(Vec3(0.0, side, 0.0), theta, phi, J);
    DOUBLES_EQUAL(0.0, theta, 0.0);
    DOUBLES_EQUAL(-side * 90.0 * test::degree, phi, 1e-15);
    CHECK(J == Mat23::Zero());
  }
}

TEST(InverseDepth, point_and_its_jacobian_of_eq_6) {
  for_each_angle([](double theta, double phi) {
    for (const double rho : {0.05, 0.3, 2.0, -0.4}) {
      Vec6 y;
      y << 0.4, -1.2, 3.0, theta, phi, rho;
      Mat<3, 6> J;
      const Vec3 X = inverse_depth::point_T(y, J);
      CHECK((X - (y.head<3>() + inverse_depth::ray_T(theta, phi) / rho)).norm() < 1e-13);
      const auto point = [](const Vec6& at) -> Vec3 {
        Mat<3, 6> ignored;
        return inverse_depth::point_T(at, ignored);
      };
      CHECK((test::jacobian_error<3, 6>(J, point, y) < 1e-7));
    }
  });
}

TEST(InverseDepth, linearity_index_is_the_formula_of_eq_9) {
  test::Samples samples(11);
  for (int i = 0; i < 200; ++i) {
    const Vec6 y = samples.feature().y;
    const Vec3 r_TC = samples.matrix<3>(4.0);
    const double sigma_rho = samples.uniform(0.001, 0.2);
    const Vec3 m = inverse_depth::ray_T(y(3), y(4));
    const Vec3 X = y.head<3>() + m / y(5);
    const Vec3 now = X - r_TC;
    const double alpha = std::atan2(m.cross(now).norm(), m.dot(now));
    const double expected = 4.0 * (sigma_rho / (y(5) * y(5))) / now.norm() * std::fabs(std::cos(alpha));
    DOUBLES_EQUAL(expected, inverse_depth::euclidean_linearity_index(y, sigma_rho, r_TC), 1e-12 * (1.0 + expected));
  }
}

TEST(InverseDepth, linearity_index_is_infinite_where_there_is_no_point) {
  Vec6 y = Vec6::Zero();
  for (const double rho : {0.0, -0.0, -1e-9, -3.0, std::numeric_limits<double>::quiet_NaN()}) {
    y(5) = rho;
    CHECK(std::isinf(inverse_depth::euclidean_linearity_index(y, 0.1, Vec3(0.0, 0.0, 1.0))));
  }
  y(5) = 0.5;  // the camera at the point itself
  CHECK(std::isinf(inverse_depth::euclidean_linearity_index(y, 0.1, Vec3(0.0, 0.0, 2.0))));
}

}  // namespace relnav
