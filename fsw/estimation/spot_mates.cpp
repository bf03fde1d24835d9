#include "fsw/estimation/spot_mates.hpp"

#include <algorithm>
#include <cmath>

#include "fsw/attitude/so3.hpp"

namespace relnav {
namespace {

/// 1 sigma of a spot's direction, rad.
double sigma_rad(const SpotScene& scene, std::size_t camera, std::size_t spot) {
  const double own = scene.spots[camera][spot].sigma_px, model = scene.settings.model_sigma_px;
  return std::sqrt(own * own + model * model) / scene.rig[camera].model.intrinsics().fu;
}

double radius_of(const TargetModel& target) {
  double radius2 = 0.0;
  for (const TargetFeature& f : target.features) radius2 = std::max(radius2, f.p_T.squaredNorm());
  return std::sqrt(radius2);
}

}  // namespace

void SpotMates::build(const SpotScene& scene) {
  mated_ = 0;
  const RigCamera& second = scene.rig[1];
  const Vec3 centre_C = -(second.R_KC.transpose() * second.t_KC);  // of the second camera
  const double radius = radius_of(scene.target);
  const double farthest = 1.0 / (scene.settings.range_max_m + radius);
  const double nearest_m = std::max(scene.settings.range_min_m - radius, 1e-3);
  std::array<Vec3, config::max_spots> rays_b;
  for (std::size_t b = 0; b < scene.spots[1].size(); ++b) rays_b[b] = second.R_KC.transpose() * scene.fields[1].ray(b);
  for (std::size_t a = 0; a < scene.spots[0].size(); ++a) {
    places_[a].clear();
    if ((scene.fields[0].present() >> a & 1U) == 0) continue;
    const Vec3& ray = scene.fields[0].ray(a);
    const double along_m = ray.dot(centre_C);
    const Vec3 across = centre_C - along_m * ray;
    const double baseline_m = across.norm();  // as the ray sees it
    if (!(baseline_m > 0.0)) continue;
    const Vec3 towards = across / baseline_m;
    const Vec3 normal = cross_matrix(towards) * ray;  // of the epipolar plane
    const double sigma_a = sigma_rad(scene, 0, a);
    for (std::size_t b = 0; b < scene.spots[1].size() && !places_[a].full(); ++b) {
      const double forward = ray.dot(rays_b[b]);
      if ((scene.fields[1].present() >> b & 1U) == 0 || !(forward > 0.0)) continue;
      const double sigma_b = sigma_rad(scene, 1, b);
      const double tolerance = scene.settings.gate_sigma * std::sqrt(sigma_a * sigma_a + sigma_b * sigma_b);
      if (!(std::abs(normal.dot(rays_b[b])) < tolerance)) continue;
      // A point at depth z on the ray is seen from the second camera under the angle to the ray whose tangent is
      // baseline / (z - along).
      const double tangent = -towards.dot(rays_b[b]) / forward;
      const double reach = tolerance * (1.0 + tangent * tangent);
      const auto inverse_depth = [&](double t) { return t / (baseline_m + along_m * t); };
      const double nearest = std::min(inverse_depth(tangent + reach), 1.0 / nearest_m);
      const double deepest = std::max(inverse_depth(tangent - reach), farthest);
      if (!(nearest >= deepest)) continue;
      const double from_m = 1.0 / nearest, to_m = 1.0 / deepest;
      if (places_[a].push_back({0.5 * (from_m + to_m) * ray, 0.5 * (to_m - from_m)}) == Status::ok) {
        mated_ |= SpotField::Mask{1} << a;
      }
    }
  }
}

SpotMates::Span SpotMates::distance(std::size_t a, std::size_t b) const {
  double least = 1e9, most = 0.0;
  for (const Place& p : places_[a]) {
    for (const Place& q : places_[b]) {
      const double middle = (p.p_C - q.p_C).norm();
      // Both at the end of what the noise allows is rarer by far than one of them.
      const double reach = std::sqrt(p.half_m * p.half_m + q.half_m * q.half_m);
      least = std::min(least, middle - reach);
      most = std::max(most, middle + reach);
    }
  }
  least = std::max(least, 0.0);
  return {least * least, most * most};
}

}  // namespace relnav
