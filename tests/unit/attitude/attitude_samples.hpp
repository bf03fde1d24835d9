#pragma once
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "fsw/base/generator.hpp"
#include "fsw/math/types.hpp"

namespace relnav::test {

inline constexpr long double pi_l = 3.14159265358979323846264338327950288L;
inline constexpr double pi = 3.14159265358979323846;

/// Active rotation by `angle` (rad) about `axis`, in long double with the C library: shares nothing with fsw.
inline Mat3 reference_dcm(const Vec3& axis, long double angle) {
  long double n[3];
  for (int k = 0; k < 3; ++k) n[k] = static_cast<long double>(axis(k));
  const long double length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
  for (long double& component : n) component /= length;
  const long double s = std::sin(angle);
  const long double half = std::sin(angle / 2);
  const long double versine = 2 * half * half;  // 1 - cos(angle)
  const long double cross[3][3] = {{0, -n[2], n[1]}, {n[2], 0, -n[0]}, {-n[1], n[0], 0}};
  Mat3 R;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) {
      const long double identity = r == c ? 1 : 0;
      R(r, c) = static_cast<double>(identity + s * cross[r][c] + versine * (n[r] * n[c] - identity));
    }
  }
  return R;
}
inline Mat3 reference_dcm(const Vec3& axis, double angle) {
  return reference_dcm(axis, static_cast<long double>(angle));
}

struct RotationSample {
  std::string name;
  Vec3 axis;
  long double angle;  // rad

  [[nodiscard]] Mat3 dcm() const { return reference_dcm(axis, angle); }
  [[nodiscard]] Vec3 rotation_vector() const { return static_cast<double>(angle) * axis.normalized(); }
};

/// The identity, both sides of every threshold in fsw/attitude, exactly 180 deg, and beyond, about special and oblique axes.
inline std::vector<RotationSample> rotation_samples() {
  const std::vector<std::pair<std::string, Vec3>> axes = {
      {"x", Vec3(1, 0, 0)},
      {"y", Vec3(0, 1, 0)},
      {"z", Vec3(0, 0, 1)},
      {"-z", Vec3(0, 0, -1)},
      {"xy", Vec3(1, 1, 0)},
      {"-x+z", Vec3(-1, 0, 1)},
      {"xyz", Vec3(1, 1, 1)},
      {"oblique", Vec3(0.3, -0.8, 0.5)},
      {"almost x", Vec3(1, 1e-9, -1e-7)},
  };
  const std::vector<std::pair<std::string, long double>> angles = {
      {"0", 0},
      {"1e-300", 1e-300L},
      {"1e-8", 1e-8L},
      {"below the logarithm's series limit", 2e-4L * (1 - 1e-6L)},
      {"above the logarithm's series limit", 2e-4L * (1 + 1e-6L)},
      {"below the quaternion's series limit", 2 * std::sqrt(1e-3L) * (1 - 1e-9L)},
      {"above the quaternion's series limit", 2 * std::sqrt(1e-3L) * (1 + 1e-9L)},
      {"below the exponential's series limit", 0.1L * (1 - 1e-9L)},
      {"above the exponential's series limit", 0.1L * (1 + 1e-9L)},
      {"1 rad", 1},
      {"90 deg - 1e-9", pi_l / 2 - 1e-9L},
      {"90 deg", pi_l / 2},
      {"90 deg + 1e-9", pi_l / 2 + 1e-9L},
      {"120 deg - 1e-9", 2 * pi_l / 3 - 1e-9L},
      {"120 deg", 2 * pi_l / 3},
      {"120 deg + 1e-9", 2 * pi_l / 3 + 1e-9L},
      {"179 deg", 179 * pi_l / 180},
      {"180 deg - 1e-9", pi_l - 1e-9L},
      {"180 deg - 1e-15", pi_l - 1e-15L},
      {"180 deg", pi_l},
      {"180 deg + 1e-15", pi_l + 1e-15L},
      {"180 deg + 1e-9", pi_l + 1e-9L},
      {"181 deg", 181 * pi_l / 180},
      {"-120 deg", -2 * pi_l / 3},
      {"270 deg", 3 * pi_l / 2},
      {"304 deg", 304 * pi_l / 180},
      {"360 deg - 1e-6", 2 * pi_l - 1e-6L},
      {"360 deg", 2 * pi_l},
      {"400 deg", 400 * pi_l / 180},
  };
  std::vector<RotationSample> samples;
  for (const auto& [axis_name, axis] : axes) {
    for (const auto& [angle_name, angle] : angles) {
      samples.push_back({angle_name + " about " + axis_name, axis, angle});
    }
  }
  return samples;
}

/// Uniform in a cube of half-width `size`.
inline Vec3 random_vector(Generator& generator, double size) {
  const double x = generator.uniform();
  const double y = generator.uniform();
  const double z = generator.uniform();
  return size * (2.0 * Vec3(x, y, z) - Vec3::Ones());
}

/// Largest absolute difference of the elements; infinite for NaN.
inline double max_difference(const Mat3& A, const Mat3& B) {
  double largest = 0.0;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) {
      const double difference = std::fabs(A(r, c) - B(r, c));
      if (!(difference <= largest)) largest = std::isfinite(difference) ? difference : HUGE_VAL;
    }
  }
  return largest;
}

}  // namespace relnav::test
