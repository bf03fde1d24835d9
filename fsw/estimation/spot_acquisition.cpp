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
constexpr int triples_a_round = 2;
// In three-point problems, for each camera.
constexpr int work_of_refinement = 15;
constexpr int work_of_preparation = 100;

bool are_valid(const SpotSearchSettings& s, const AttitudePrior& prior) {
  return s.check() == Status::ok && (!prior.given || (std::isfinite(prior.R_CT.sum()) && prior.cone_rad > 0.0));
}

bool is_believed(const SpotScene& scene, const SpotAgreement& a) {
  return a.false_alarms <= scene.settings.max_false_alarms ||
         (a.whole && a.false_alarms <= scene.settings.max_false_alarms_whole);
}

int cameras_in_use(const SpotScene& scene) {
  int count = 0;
  for (std::size_t c = 0; c < scene.rig.size(); ++c) count += scene.fields[c].count() > 0 ? 1 : 0;
  return count;
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

void SpotAcquisition::restart() {
  steps_ = 0;
  camera_ = 0;
  phase_ = Phase::mated;
  has_spots_ = false;
  has_order_ = false;
  trial_.abandon();
}

void SpotAcquisition::change_spots() {
  if (phase_ == Phase::weigh) restart();
  if (trial_.is_open()) --steps_;  // what was tried in part is tried again
  has_spots_ = false;
  has_order_ = false;
  trial_.abandon();
}

Status SpotAcquisition::prepare(const SpotScene& scene) {
  const Status status = triples_.build(scene.target);
  if (status != Status::ok) return status;
  int total = 0, most = 0;
  for (std::size_t c = 0; c < scene.rig.size(); ++c) {
    fields_[c].build(scene.rig[c].model, scene.spots[c], scene.settings.gate_px);
    total += fields_[c].count();
    most = std::max(most, fields_[c].count());
  }
  return total < 4 || most < 3 ? Status::too_few_features : Status::ok;
}

void SpotAcquisition::build_order(const SpotScene& scene) {
  SpotField::Mask which = fields_[camera_].present();
  if (phase_ == Phase::mated) {
    mates_.build(scene);
    which = mates_.mated();
  }
  const double focal_px = scene.rig[camera_].model.intrinsics().fu;
  order_.build(fields_[camera_], which, 2.0 * scene.settings.gate_px / focal_px);
  order_.skip(steps_);
  has_order_ = true;
}

bool SpotAcquisition::next_phase(const SpotScene& scene) {
  camera_ = phase_ == Phase::mated ? std::uint16_t{0} : static_cast<std::uint16_t>(camera_ + 1);
  phase_ = Phase::single;
  steps_ = 0;
  has_order_ = false;
  return camera_ < scene.rig.size();
}

bool SpotAcquisition::open_next(const SpotScene& scene, const AcquiredSpots& out) {
  if (phase_ == Phase::weigh) return open_next_to_weigh(scene, out);
  if (phase_ == Phase::mated && (scene.rig.size() < 2 || fields_[1].count() < 3)) return false;
  if (!has_order_) build_order(scene);
  SpotTriples::Triple spots{};
  if (!order_.next(spots)) return false;
  steps_ = order_.steps();
  if (phase_ == Phase::mated) {
    trial_.begin_mated(mates_, spots, refined_per_triple);
  } else {
    trial_.begin(camera_, spots, needed_hits(scene, camera_), refined_per_triple);
  }
  return true;
}

bool SpotAcquisition::close_trial(const SpotScene& scene, AcquiredSpots& out) {
  const SpotHypotheses& best = trial_.best();
  bool found = phase_ == Phase::weigh;
  for (std::size_t k = 0; k < best.size(); ++k) {
    out.effort.work += work_of_refinement * cameras_in_use(scene);
    if (refine_hypothesis(scene, best[k].pose, out.effort.poses, previous_, candidate_) != Status::ok) continue;
    if (found) {
      offer(candidate_, out);
    } else if (is_believed(scene, candidate_)) {
      out.best = candidate_;
      found = true;
    }
  }
  return found;
}

void SpotAcquisition::begin_weighing() {
  phase_ = Phase::weigh;
  round_ = 0;
  triples_of_round_ = 0;
}

void SpotAcquisition::begin_round(const SpotScene& scene, const AcquiredSpots& out) {
  before_round_ = out.best.estimate;
  explained_count_ = 0;
  for (std::size_t c = 0; c < scene.rig.size(); ++c) {
    std::array<std::uint8_t, config::max_spots> these{};
    const std::size_t n = explained(scene, out.best, static_cast<std::uint16_t>(c), these);
    if (n <= explained_count_) continue;
    camera_ = static_cast<std::uint16_t>(c);
    explained_count_ = n;
    explained_ = these;
  }
  least_hits_ = std::max(scene.rig.size() > 1 ? 0 : 1, static_cast<int>(explained_count_) - 5);
}

bool SpotAcquisition::open_next_to_weigh(const SpotScene& scene, const AcquiredSpots& out) {
  for (; round_ < most_rounds; ++round_) {
    if (triples_of_round_ == 0) begin_round(scene, out);
    SpotTriples::Triple t{};
    if (triples_of_round_ < triples_a_round && widest_triangle(fields_[camera_], explained_, explained_count_, t)) {
      ++triples_of_round_;
      trial_.begin(camera_, t, least_hits_, SpotHypotheses::capacity);
      const auto in_triple = [&](std::uint8_t s) { return s == t[0] || s == t[1] || s == t[2]; };
      const auto end = explained_.begin() + static_cast<std::ptrdiff_t>(explained_count_);
      explained_count_ =
          static_cast<std::size_t>(std::remove_if(explained_.begin(), end, in_triple) - explained_.begin());
      return true;
    }
    triples_of_round_ = 0;
    if (are_same_pose(out.best.estimate, before_round_)) return false;
  }
  return false;
}

Status SpotAcquisition::conclude(const SpotScene& scene, AcquiredSpots& out) {
  restart();
  if (!is_believed(scene, out.best)) return Status::no_data;
  out.ambiguous = has_other_ && !are_same_pose(out.best.estimate, out.other.estimate) &&
                  out.other.cost - out.best.cost < scene.settings.ambiguous_chi2;
  return Status::ok;
}

Status SpotAcquisition::acquire(const CameraRig& rig, const TargetModel& target, const RigSpots& spots,
                                const SpotSearchSettings& settings, const AttitudePrior& prior, AcquiredSpots& out) {
  if (!are_valid(settings, prior)) return Status::invalid_argument;
  if (rig.empty()) return Status::not_configured;
  const double least_trace = prior.cone_rad < pi ? 1.0 + 2.0 * math::cos(prior.cone_rad) : -2.0;
  const SpotScene scene{rig, target, spots, fields_, settings, prior, least_trace};
  const int limit = settings.max_hypotheses + (has_spots_ ? out.effort.work : 0);
  if (!has_spots_) {
    const Status status = prepare(scene);
    if (status != Status::ok) return status;
    has_spots_ = true;
    has_other_ = false;
    out.effort = {0, 0, work_of_preparation * cameras_in_use(scene)};
    out.ambiguous = false;
  }
  while (out.effort.work < limit) {  // bound: max_hypotheses and the phases: a turn works, or ends a phase
    if (!trial_.is_open() && !open_next(scene, out)) {
      if (phase_ == Phase::weigh) return conclude(scene, out);
      if (next_phase(scene)) continue;
      restart();
      return Status::no_data;
    }
    if (!trial_.advance(scene, triples_, limit, out.effort)) break;
    if (close_trial(scene, out) && phase_ != Phase::weigh) begin_weighing();
  }
  return Status::unfinished;
}

}  // namespace relnav
