#include "fsw/estimation/marker_triples.hpp"

#include <algorithm>
#include <cmath>

#include "fsw/attitude/so3.hpp"

namespace relnav {
namespace {

/// Height of a triangle over its longest side under which it gives no useful attitude.
constexpr double least_height = 0.05;
/// Cosine of the angle between two normals under which their faces are never seen together.
constexpr double opposite_faces = -0.94;

bool is_flat(const Vec3& a, const Vec3& b, const Vec3& c) {
  const double longest2 = std::max({(a - b).squaredNorm(), (b - c).squaredNorm(), (a - c).squaredNorm()});
  const double doubled_area = (cross_matrix(Vec3(b - a)) * (c - a)).norm();
  return !(doubled_area > least_height * longest2);
}

bool are_opposite(const Vec3& a, const Vec3& b) { return a.dot(b) < opposite_faces; }

}  // namespace

Status MarkerTriples::build(const TargetModel& target) {
  size_ = 0;
  const std::size_t n = target.features.size();
  if (n > max_search_markers) return Status::invalid_argument;
  if (n < 4) return Status::too_few_features;
  for (const TargetFeature& f : target.features) {
    if (!std::isfinite(f.p_T.sum() + f.normal_T.sum())) return Status::invalid_argument;
  }
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = i + 1; j < n; ++j) {
      for (std::size_t k = j + 1; k < n; ++k) {
        const TargetFeature &a = target.features[i], &b = target.features[j], &c = target.features[k];
        if (is_flat(a.p_T, b.p_T, c.p_T) || are_opposite(a.normal_T, b.normal_T) ||
            are_opposite(b.normal_T, c.normal_T) || are_opposite(a.normal_T, c.normal_T)) {
          continue;
        }
        Triple& triple = triples_[size_];
        triple.marker = {static_cast<std::uint8_t>(i), static_cast<std::uint8_t>(j), static_cast<std::uint8_t>(k)};
        if (make_p3p_points({a.p_T, b.p_T, c.p_T}, triple.points) == Status::ok) ++size_;
      }
    }
  }
  return size_ > 0 ? Status::ok : Status::rank_deficient;
}

}  // namespace relnav
