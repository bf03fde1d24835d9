#include "fsw/estimation/spot_acquisition.hpp"

#include <algorithm>
#include <cmath>

#include "fsw/attitude/so3.hpp"
#include "fsw/estimation/chance_match.hpp"
#include "fsw/math/elementary.hpp"

namespace relnav {
namespace {

constexpr std::size_t refined_per_triple = 4;
constexpr double rare = 5e-3;
constexpr int most_needed_hits = 3;
constexpr int most_rounds = 3;

bool are_valid(const SpotSearchSettings& s, const AttitudePrior& prior) {
  return s.check() == Status::ok && (!prior.given || (std::isfinite(prior.R_CT.sum()) && prior.cone_rad > 0.0));
}

bool is_believed(const SpotScene& scene, const SpotAgreement& a) {
  return a.false_alarms <= scene.settings.max_false_alarms ||
         (a.whole && a.false_alarms <= scene.settings.max_false_alarms_whole);
}

/// Spots beyond the three founders that make a hypothesis worth refining: more than chance gives one in 200 of them.
int needed_hits(const SpotScene& scene, std::uint16_t camera) {
  const auto markers = static_cast<int>(scene.target.features.size());
  const LightSpots& spots = scene.spots[camera];
  Vec2 low = spots[0].uv_px, high = spots[0].uv_px;
  for (const LightSpot& s : spots) {
    low = low.cwiseMin(s.uv_px);
    high = high.cwiseMax(s.uv_px);
  }
  const Vec2 size = high - low;
  const double gate_area = 3.2 * scene.settings.gate_px * scene.settings.gate_px;
  const double p =
      std::min(0.5, static_cast<double>(spots.size()) * gate_area / std::max(gate_area, size.x() * size.y()));
  int hits = 1;
  // bound: most_needed_hits
  while (hits < most_needed_hits && binomial_tail(markers - 3, hits, p) > rare) ++hits;
  // A second camera counts on its own.
  const int possible = scene.rig.size() > 1 ? 1 : std::min(markers, scene.fields[camera].count()) - 3;
  return std::clamp(hits, scene.rig.size() > 1 ? 0 : 1, std::max(possible, scene.rig.size() > 1 ? 0 : 1));
}

/// Explained spots of a camera, by position in its LightSpots.
std::size_t explained(const SpotScene& scene, const SpotAgreement& a, std::uint16_t camera,
                      std::array<std::uint8_t, config::max_spots>& out) {
  std::size_t count = 0;
  const LightSpots& spots = scene.spots[camera];
  for (std::size_t s = 0; s < spots.size(); ++s) {
    if ((scene.fields[camera].present() >> s & 1U) == 0) continue;
    for (const PoseObservation& o : a.observations) {
      if (o.camera == camera && o.uv_px == spots[s].uv_px) {
        out[count++] = static_cast<std::uint8_t>(s);
        break;
      }
    }
  }
  return count;
}

/// The widest triangle among the first `count` spots; false: fewer than 3.
bool widest_triangle(const SpotField& field, const std::array<std::uint8_t, config::max_spots>& spot, std::size_t count,
                     SpotTriples::Triple& out) {
  double best = -1.0;
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t j = i + 1; j < count; ++j) {
      const Mat3 side = cross_matrix(Vec3(field.ray(spot[j]) - field.ray(spot[i])));
      for (std::size_t k = j + 1; k < count; ++k) {
        const double area2 = (side * (field.ray(spot[k]) - field.ray(spot[i]))).squaredNorm();
        if (!(area2 > best)) continue;
        best = area2;
        out = {spot[i], spot[j], spot[k]};
      }
    }
  }
  return best >= 0.0;
}

}  // namespace

void SpotAcquisition::offer(const SpotAgreement& candidate, AcquiredSpots& out) {
  if (are_same_pose(out.best.estimate, candidate.estimate)) {
    if (candidate.cost < out.best.cost) out.best = candidate;
    return;
  }
  if (candidate.cost < out.best.cost) {
    out.other = out.best;
    out.best = candidate;
    has_other_ = true;
  } else if (!has_other_ || candidate.cost < out.other.cost) {
    out.other = candidate;
    has_other_ = true;
  }
}

Status SpotAcquisition::search(const SpotScene& scene, std::uint16_t camera, AcquiredSpots& out) {
  const double focal_px = scene.rig[camera].model.intrinsics().fu;
  order_.build(fields_[camera], 2.0 * scene.settings.gate_px / focal_px);
  order_.skip(steps_);
  const int least_hits = needed_hits(scene, camera);
  SpotTriples::Triple spots{};
  while (order_.next(spots)) {
    SpotHypotheses best(refined_per_triple);
    try_spots(scene, triples_, camera, spots, least_hits, out.effort, best);
    bool found = false;
    for (std::size_t k = 0; k < best.size(); ++k) {
      if (refine_hypothesis(scene, best[k].pose, out.effort.poses, previous_, candidate_) != Status::ok) continue;
      if (found) {
        offer(candidate_, out);
      } else if (is_believed(scene, candidate_)) {
        out.best = candidate_;
        found = true;
      }
    }
    if (found) return Status::ok;
    if (out.effort.solved >= scene.settings.max_hypotheses) {
      steps_ = order_.steps();
      camera_ = camera;
      return Status::no_data;
    }
  }
  steps_ = 0;
  camera_ = 0;
  return Status::no_data;
}

void SpotAcquisition::look_for_others(const SpotScene& scene, AcquiredSpots& out) {
  for (int round = 0; round < most_rounds; ++round) {
    const Pose before = out.best.estimate.pose;
    // The camera that explains most. Two triples without a common spot: an explanation with one spot less has one of them.
    std::array<std::uint8_t, config::max_spots> spot{};
    std::uint16_t camera = 0;
    std::size_t count = 0;
    for (std::size_t c = 0; c < scene.rig.size(); ++c) {
      std::array<std::uint8_t, config::max_spots> these{};
      const std::size_t n = explained(scene, out.best, static_cast<std::uint16_t>(c), these);
      if (n <= count) continue;
      camera = static_cast<std::uint16_t>(c);
      count = n;
      spot = these;
    }
    const int least_hits = std::max(scene.rig.size() > 1 ? 0 : 1, static_cast<int>(count) - 5);
    for (int k = 0; k < 2; ++k) {
      SpotTriples::Triple triple{};
      if (!widest_triangle(fields_[camera], spot, count, triple)) break;
      SpotHypotheses best;
      SearchEffort effort;
      try_spots(scene, triples_, camera, triple, least_hits, effort, best);
      out.effort.solved += effort.solved;
      for (std::size_t i = 0; i < best.size(); ++i) {
        if (refine_hypothesis(scene, best[i].pose, out.effort.poses, previous_, candidate_) == Status::ok)
          offer(candidate_, out);
      }
      const auto in_triple = [&](std::uint8_t s) { return s == triple[0] || s == triple[1] || s == triple[2]; };
      count = static_cast<std::size_t>(std::remove_if(spot.begin(), spot.begin() + count, in_triple) - spot.begin());
    }
    if ((out.best.estimate.pose.R_CT - before.R_CT).norm() < 1e-6) return;
  }
}

Status SpotAcquisition::acquire(const CameraRig& rig, const TargetModel& target, const RigSpots& spots,
                                const SpotSearchSettings& settings, const AttitudePrior& prior, AcquiredSpots& out) {
  if (!are_valid(settings, prior)) return Status::invalid_argument;
  if (rig.empty()) return Status::not_configured;
  Status status = triples_.build(target);
  if (status != Status::ok) return status;
  int total = 0, most = 0;
  for (std::size_t c = 0; c < rig.size(); ++c) {
    fields_[c].build(rig[c].model, spots[c], settings.gate_px);
    total += fields_[c].count();
    most = std::max(most, fields_[c].count());
  }
  if (total < 4 || most < 3) return Status::too_few_features;
  const double least_trace = prior.cone_rad < pi ? 1.0 + 2.0 * math::cos(prior.cone_rad) : -2.0;
  const SpotScene scene{rig, target, spots, fields_, settings, prior, least_trace};

  out.effort = {};
  out.ambiguous = false;
  has_other_ = false;
  status = Status::no_data;
  for (std::size_t c = camera_ < rig.size() ? camera_ : 0; c < rig.size() && status != Status::ok; ++c) {
    if (fields_[c].count() < 3 || out.effort.solved >= settings.max_hypotheses) continue;
    status = search(scene, static_cast<std::uint16_t>(c), out);
  }
  if (status != Status::ok) return status;
  restart();
  look_for_others(scene, out);
  if (!is_believed(scene, out.best)) return Status::no_data;
  out.ambiguous = has_other_ && !are_same_pose(out.best.estimate, out.other.estimate) &&
                  out.other.cost - out.best.cost < settings.ambiguous_chi2;
  return Status::ok;
}

}  // namespace relnav
