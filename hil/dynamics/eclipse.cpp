#include "hil/dynamics/eclipse.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "hil/dynamics/gravity.hpp"

namespace relnav::hil {
namespace {

double arc_cosine(double x) { return std::acos(std::clamp(x, -1.0, 1.0)); }

}  // namespace

double sunlight_at(const Vec3& r_I, const Vec3& sun_I) {
  const Vec3 to_sun_I = sun_distance_m * sun_I - r_I;
  const double a = std::asin(sun_radius_m / to_sun_I.norm());              // half angle of the sun
  const double b = std::asin(std::min(1.0, earth_radius_m / r_I.norm()));  // of the Earth
  const Vec3 earth_I = -r_I.normalized();
  const Vec3 s_I = to_sun_I.normalized();
  const double c = std::atan2(earth_I.cross(s_I).norm(), earth_I.dot(s_I));  // between their centres
  if (c >= a + b) return 1.0;
  if (c <= b - a) return 0.0;
  if (c <= a - b) return 1.0 - b * b / (a * a);  // ring, from very far
  const double x = (c * c + a * a - b * b) / (2.0 * c);
  const double y = std::sqrt(std::max(0.0, a * a - x * x));
  const double covered = a * a * arc_cosine(x / a) + b * b * arc_cosine((c - x) / b) - c * y;
  return std::clamp(1.0 - covered / (pi * a * a), 0.0, 1.0);
}

}  // namespace relnav::hil
