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

/// The determinant of the rays has the sign of N'(p - c), N = (b - a) x (c - a) and c the camera's centre. With N (or -N) a
/// sum of the normals n with weights >= 0, N'(c - p) is one of the n'(c - p), all positive if every face is seen, as far as
/// the other markers lie behind each face (n'(p' - p) <= 0), which is checked.
int forced_orientation(const TargetFeature& a, const TargetFeature& b, const TargetFeature& c) {
  const std::array<const TargetFeature*, 3> f{&a, &b, &c};
  const Vec3 N = (cross_matrix(Vec3(b.p_T - a.p_T)) * (c.p_T - a.p_T)).normalized();
  constexpr double slack = 0.05;  // m
  for (const TargetFeature* i : f) {
    if (!(i->normal_T.squaredNorm() > 0.0)) return 0;
    for (const TargetFeature* j : f) {
      if (i->normal_T.dot(j->p_T - i->p_T) > slack) return 0;
    }
  }
  // Weights by Cramer's rule; normals that depend on each other (two on one face) have none, which gives up the gain only.
  const Mat3 cross_bc = cross_matrix(b.normal_T);
  const double det = a.normal_T.dot(cross_bc * c.normal_T);
  if (std::abs(det) < 0.2) {
    // One face: the plane of the three is that of the face.
    constexpr double same = 0.98;
    if (N.dot(a.normal_T) > same && N.dot(b.normal_T) > same && N.dot(c.normal_T) > same) return -1;
    if (-N.dot(a.normal_T) > same && -N.dot(b.normal_T) > same && -N.dot(c.normal_T) > same) return 1;
    return 0;
  }
  const double wa = N.dot(cross_bc * c.normal_T) / det;
  const double wb = N.dot(cross_matrix(c.normal_T) * a.normal_T) / det;
  const double wc = N.dot(cross_matrix(a.normal_T) * b.normal_T) / det;
  constexpr double least = 0.05;
  if (wa > least && wb > least && wc > least) return -1;
  if (wa < -least && wb < -least && wc < -least) return 1;
  return 0;
}

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
        if (make_p3p_points({a.p_T, b.p_T, c.p_T}, triple.points) != Status::ok) continue;
        triple.orientation = forced_orientation(a, b, c);
        ++size_;
      }
    }
  }
  return size_ > 0 ? Status::ok : Status::rank_deficient;
}

}  // namespace relnav
