#include "fsw/estimation/spot_hypotheses.hpp"

#include <algorithm>
#include <cmath>

#include "fsw/attitude/so3.hpp"

namespace relnav {
namespace {

constexpr double grazing = 0.05;  // cosine

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
    if (!faces(f, centre_T, grazing)) continue;
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

void try_spots(const SpotScene& scene, const MarkerTriples& triples, std::uint16_t camera,
               const std::array<std::uint8_t, 3>& spots, int least_hits, SearchEffort& effort, SpotHypotheses& best) {
  const SpotField& field = scene.fields[camera];
  const Mask founding_spots = Mask{1} << spots[0] | Mask{1} << spots[1] | Mask{1} << spots[2];
  double radius2 = 0.0;
  for (const TargetFeature& f : scene.target.features) radius2 = std::max(radius2, f.p_T.squaredNorm());
  // No marker is nearer than this, which bounds the angle between two of them.
  const RigCamera& rig_camera = scene.rig[camera];
  const double nearest = scene.settings.range_min_m - std::sqrt(radius2) - rig_camera.t_KC.norm();
  const double half_inverse2 = nearest > 0.0 ? 0.5 / (nearest * nearest) : 1e300;
  for (const auto& order : orders) {
    const std::array<Vec3, 3> rays{field.ray(spots[order[0]]), field.ray(spots[order[1]]), field.ray(spots[order[2]])};
    const double turn12 = 1.0 - rays[0].dot(rays[1]);
    const double turn13 = 1.0 - rays[0].dot(rays[2]);
    const double turn23 = 1.0 - rays[1].dot(rays[2]);
    const int orientation = rays[0].dot(cross_matrix(rays[1]) * rays[2]) > 0.0 ? 1 : -1;
    for (std::size_t k = 0; k < triples.size(); ++k) {
      const MarkerTriples::Triple& triple = triples[k];
      if (triple.orientation == -orientation) continue;
      if (turn12 > triple.points.a12 * half_inverse2 || turn13 > triple.points.a13 * half_inverse2 ||
          turn23 > triple.points.a23 * half_inverse2) {
        continue;
      }
      std::array<Pose, 4> poses_K;
      const int count = solve_p3p(triple.points, rays, poses_K);
      ++effort.solved;
      std::uint32_t founders = 0;
      for (const std::uint8_t m : triple.marker) founders |= 1U << m;
      for (int s = 0; s < count; ++s) {
        const Pose& pose_K = poses_K[static_cast<std::size_t>(s)];
        const Pose pose = camera == 0 ? pose_K : from_camera(rig_camera, pose_K);
        if (!is_allowed(scene, pose)) continue;
        const Vec3 centre_T = camera_centre_T(pose_K);
        bool seen = true;
        for (const std::uint8_t m : triple.marker) seen = seen && faces(scene.target.features[m], centre_T, grazing);
        if (!seen) continue;
        ++effort.poses;
        Trial trial;
        // Another camera can only add, so its hits must not be counted on for the bound of a list that includes them.
        const bool alone = scene.rig.size() == 1;
        const int needed = alone ? std::max(least_hits, best.least_hits()) : least_hits;
        if (!count_hits(scene, camera, pose_K, founders, founding_spots, needed, trial)) continue;
        for (std::size_t other = 0; other < scene.rig.size(); ++other) {
          if (other == camera || scene.fields[other].count() == 0) continue;
          const auto number = static_cast<std::uint16_t>(other);
          static_cast<void>(count_hits(scene, number, in_camera(scene.rig[other], pose), 0, 0, 0, trial));
        }
        best.offer({pose, trial.hits, trial.d2});
      }
    }
  }
}

}  // namespace relnav
