#include "fsw/estimation/spot_hypotheses.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "fsw/attitude/so3.hpp"

namespace relnav {
namespace {

constexpr double grazing_cosine = 0.05;

using Mask = SpotField::Mask;

struct Trial {
  int hits = 0;
  double d2 = 0.0;
};

/// Spots explained by the markers not in `founders`; gives up (false) once `needed` is out of reach.
bool count_hits(const SpotScene& scene, std::uint16_t camera, const Pose& pose_K, std::uint32_t founders, Mask taken,
                int needed, Trial& trial) {
  const Vec3 centre_T = camera_centre_T(pose_K);
  const SpotField& field = scene.fields[camera];
  const TargetFeature* features = scene.target.features.data();
  const auto n = static_cast<int>(scene.target.features.size());
  int left = 0;
  for (int i = 0; i < n; ++i) left += (founders >> i & 1U) == 0 ? 1 : 0;
  for (int i = 0; i < n; ++i) {
    if ((founders >> i & 1U) != 0) continue;
    if (trial.hits + left < needed) return false;
    --left;
    const TargetFeature& f = features[i];
    if (!faces(f, centre_T, grazing_cosine)) continue;
    const Vec3 p = pose_K.R_CT * f.p_T + pose_K.t_CT;
    if (!(p.z() > 0.0)) return false;
    const double scale = 1.0 / p.z();
    double d2 = 0.0;
    const int spot = field.nearest(p.x() * scale, p.y() * scale, taken, d2);
    if (spot < 0) continue;
    taken |= Mask{1} << static_cast<unsigned>(spot);
    trial.d2 += d2;
    ++trial.hits;
  }
  return trial.hits >= needed;
}

constexpr std::array<std::array<std::uint8_t, 3>, 6> orders{
    {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}}};

}  // namespace

void SpotHypotheses::offer(const SpotHypothesis& h) {
  const auto better = [](const SpotHypothesis& a, const SpotHypothesis& b) {
    return a.hits > b.hits || (a.hits == b.hits && a.d2 < b.d2);
  };
  if (list_.size() == keep_) {
    if (!better(h, list_[keep_ - 1])) return;
    list_.pop_back();
  }
  if (list_.push_back(h) != Status::ok) return;
  for (std::size_t i = list_.size() - 1; i > 0 && better(h, list_[i - 1]); --i) {
    list_[i] = list_[i - 1];
    list_[i - 1] = h;
  }
}

void SpotTrial::begin(std::uint16_t camera, const Spots& spots, int least_hits, std::size_t keep) {
  best_ = SpotHypotheses(keep);
  spots_ = spots;
  distance_.fill({0.0, std::numeric_limits<double>::max()});
  order_ = 0;
  triple_ = 0;
  least_hits_ = least_hits;
  camera_ = camera;
  is_open_ = true;
}

void SpotTrial::begin_mated(const SpotMates& mates, const Spots& spots, std::size_t keep) {
  begin(0, spots, 0, keep);
  distance_ = {mates.distance(spots[0], spots[1]), mates.distance(spots[0], spots[2]),
               mates.distance(spots[1], spots[2])};
}

bool SpotTrial::can_be(const MarkerTriples::Triple& triple, const Spots& order) const {
  const auto fits = [&](std::size_t i, std::size_t j, double side2) {
    const SpotMates::Span& span = distance_[static_cast<std::size_t>(order[i]) + order[j] - 1U];
    return side2 >= span.least2 && side2 <= span.most2;
  };
  return fits(0, 1, triple.points.a12) && fits(0, 2, triple.points.a13) && fits(1, 2, triple.points.a23);
}

bool SpotTrial::advance(const SpotScene& scene, const MarkerTriples& triples, int limit, SearchEffort& effort) {
  const SpotField& field = scene.fields[camera_];
  double radius2 = 0.0;
  for (const TargetFeature& f : scene.target.features) radius2 = std::max(radius2, f.p_T.squaredNorm());
  // No marker is nearer than this, which bounds the angle between two of them.
  const double nearest = scene.settings.range_min_m - std::sqrt(radius2) - scene.rig[camera_].t_KC.norm();
  const double half_inverse2 = nearest > 0.0 ? 0.5 / (nearest * nearest) : 1e300;
  for (; order_ < orders.size(); ++order_) {
    const Spots& order = orders[order_];
    const std::array<Vec3, 3> rays{field.ray(spots_[order[0]]), field.ray(spots_[order[1]]),
                                   field.ray(spots_[order[2]])};
    const double turn12 = 1.0 - rays[0].dot(rays[1]);
    const double turn13 = 1.0 - rays[0].dot(rays[2]);
    const double turn23 = 1.0 - rays[1].dot(rays[2]);
    const int orientation = rays[0].dot(cross_matrix(rays[1]) * rays[2]) > 0.0 ? 1 : -1;
    for (; triple_ < triples.size(); ++triple_) {
      if (effort.work >= limit) return false;
      const MarkerTriples::Triple& triple = triples[triple_];
      if (triple.orientation == -orientation || !can_be(triple, order)) continue;
      if (turn12 > triple.points.a12 * half_inverse2 || turn13 > triple.points.a13 * half_inverse2 ||
          turn23 > triple.points.a23 * half_inverse2) {
        continue;
      }
      solve(scene, triple, rays, effort);
    }
    triple_ = 0;
  }
  // What was only looked at: some 50 triples to a problem.
  effort.work += static_cast<int>(triples.size() * orders.size() / 50) + 1;
  is_open_ = false;
  return true;
}

void SpotTrial::solve(const SpotScene& scene, const MarkerTriples::Triple& triple, const std::array<Vec3, 3>& rays,
                      SearchEffort& effort) {
  const RigCamera& rig_camera = scene.rig[camera_];
  const Mask founding_spots = Mask{1} << spots_[0] | Mask{1} << spots_[1] | Mask{1} << spots_[2];
  std::array<Pose, 4> poses_K;
  const int count = solve_p3p(triple.points, rays, poses_K);
  ++effort.solved;
  ++effort.work;
  std::uint32_t founders = 0;
  for (const std::uint8_t m : triple.marker) founders |= 1U << m;
  for (int s = 0; s < count; ++s) {
    const Pose& pose_K = poses_K[static_cast<std::size_t>(s)];
    const Pose pose = camera_ == 0 ? pose_K : from_camera(rig_camera, pose_K);
    if (!is_allowed(scene, pose)) continue;
    const Vec3 centre_T = camera_centre_T(pose_K);
    bool seen = true;
    for (const std::uint8_t m : triple.marker) seen = seen && faces(scene.target.features[m], centre_T, grazing_cosine);
    if (!seen) continue;
    ++effort.poses;
    Trial trial;
    // Another camera can only add, so its hits must not be counted on for the bound of a list that includes them.
    const bool alone = scene.rig.size() == 1;
    const int needed = alone ? std::max(least_hits_, best_.least_hits()) : least_hits_;
    if (!count_hits(scene, camera_, pose_K, founders, founding_spots, needed, trial)) continue;
    for (std::size_t other = 0; other < scene.rig.size(); ++other) {
      if (other == camera_ || scene.fields[other].count() == 0) continue;
      const auto number = static_cast<std::uint16_t>(other);
      static_cast<void>(count_hits(scene, number, in_camera(scene.rig[other], pose), 0, 0, 0, trial));
    }
    best_.offer({pose, trial.hits, trial.d2});
  }
}

}  // namespace relnav
