#include "fsw/estimation/spot_agreement.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "fsw/estimation/chance_match.hpp"
#include "fsw/math/chi_square.hpp"

namespace relnav {
namespace {

constexpr int most_solutions = 5;
constexpr std::size_t least_spots = 4;
constexpr double grazing = 0.05;          // cosine under which a face counts as turned away
constexpr double expected_cosine = 0.25;  // from which on its marker should be seen
constexpr double border_px = 3.0;         // a marker nearer to the edge than this need not be seen
/// The fit draws the spots to itself, and a pose from three of them spreads its error: the area in which a spot would have
/// been taken for the marker is larger than that of its residual.
constexpr double reach = 4.0;
constexpr double no_foundation = 1e9;  // false alarms of a pose with fewer than three spots in every camera

struct Pair {
  double e2 = 0.0;  // over the gate, squared
  std::uint16_t marker = 0;
  std::uint16_t spot = 0;
};

double sigma_of(const SpotScene& scene, const LightSpot& spot) {
  const double m = scene.settings.model_sigma_px;
  return std::sqrt(spot.sigma_px * spot.sigma_px + m * m);
}

/// Predicted images of one camera.
struct Images {
  std::array<Vec2, config::max_target_features> uv_px;
  std::array<bool, config::max_target_features> seen{};      ///< may have a spot
  std::array<bool, config::max_target_features> expected{};  ///< should have one
};

void predict(const SpotScene& scene, std::size_t camera, const Pose& pose, Images& out) {
  const Pose pose_K = in_camera(scene.rig[camera], pose);
  const Vec3 centre_T = camera_centre_T(pose_K);
  const CameraModel& model = scene.rig[camera].model;
  for (std::size_t m = 0; m < scene.target.features.size(); ++m) {
    const TargetFeature& f = scene.target.features[m];
    out.seen[m] = faces(f, centre_T, grazing) &&
                  model.project(Vec3(pose_K.R_CT * f.p_T + pose_K.t_CT), out.uv_px[m]) == Status::ok;
    out.expected[m] = out.seen[m] && faces(f, centre_T, expected_cosine) && model.in_image(out.uv_px[m], border_px);
  }
}

/// Nearest pairs first, each marker and each spot once.
void assign(const SpotScene& scene, std::size_t camera, const Images& images, double gate_px,
            PoseObservations& observations) {
  BoundedVector<Pair, std::size_t{4} * config::max_spots> pairs;
  const LightSpots& spots = scene.spots[camera];
  for (std::size_t s = 0; s < spots.size(); ++s) {
    const double gate = gate_px > 0.0 ? gate_px : scene.settings.gate_sigma * sigma_of(scene, spots[s]);
    for (std::size_t m = 0; m < scene.target.features.size(); ++m) {
      if (!images.seen[m]) continue;
      const double e2 = (spots[s].uv_px - images.uv_px[m]).squaredNorm() / (gate * gate);
      if (!(e2 < 1.0)) continue;
      // A heap of spots on every marker says nothing: give up.
      if (pairs.push_back({e2, static_cast<std::uint16_t>(m), static_cast<std::uint16_t>(s)}) != Status::ok) return;
      for (std::size_t i = pairs.size() - 1; i > 0 && pairs[i].e2 < pairs[i - 1].e2; --i)
        std::swap(pairs[i], pairs[i - 1]);
    }
  }
  std::uint64_t markers = 0, taken = 0;
  for (const Pair& p : pairs) {
    const std::uint64_t marker = std::uint64_t{1} << p.marker, spot = std::uint64_t{1} << p.spot;
    if ((markers & marker) != 0 || (taken & spot) != 0) continue;
    markers |= marker;
    taken |= spot;
    const LightSpot& s = spots[p.spot];
    static_cast<void>(
        observations.push_back({p.marker, static_cast<std::uint16_t>(camera), s.uv_px, sigma_of(scene, s)}));
  }
}

void assign_all(const SpotScene& scene, const Pose& pose, double gate_px, PoseObservations& observations) {
  observations.clear();
  Images images;
  for (std::size_t c = 0; c < scene.rig.size(); ++c) {
    predict(scene, c, pose, images);
    assign(scene, c, images, gate_px, observations);
  }
}

bool are_equal(const PoseObservations& a, const PoseObservations& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const PoseObservation& x, const PoseObservation& y) {
    return x.feature == y.feature && x.camera == y.camera && x.uv_px == y.uv_px;
  });
}

/// Largest residual of the observations of a camera, px.
double largest_residual_px(const SpotScene& scene, const SpotAgreement& a, std::size_t camera) {
  double worst = 0.0;
  for (const PoseObservation& o : a.observations) {
    Vec2 r;
    if (o.camera != camera || whitened_residual(scene.rig, scene.target, o, a.estimate.pose, r) != Status::ok) continue;
    worst = std::max(worst, r.norm() * o.sigma_px);
  }
  return worst;
}

/// Spots per square pixel that chance could draw from near a predicted image: the denser of the neighbourhood, its own spot
/// left out, and of the surroundings of the target.
double density_at(const LightSpots& spots, const Vec2& uv_px, double around_target) {
  constexpr double radius_px = 24.0;
  double near = -1.0;
  for (const LightSpot& s : spots) near += (s.uv_px - uv_px).squaredNorm() < radius_px * radius_px ? 1.0 : 0.0;
  return std::max(around_target, near / (pi * radius_px * radius_px));
}

/// Density of the spots in the rectangle that the images fill; `founders` of them do not count.
double density_around(const SpotScene& scene, const LightSpots& spots, const Images& images, double founders) {
  Vec2 low(1e9, 1e9), high(-1e9, -1e9);
  for (std::size_t m = 0; m < scene.target.features.size(); ++m) {
    if (!images.seen[m]) continue;
    low = low.cwiseMin(images.uv_px[m]);
    high = high.cwiseMax(images.uv_px[m]);
  }
  if (!(high.x() >= low.x())) return 0.0;
  const Vec2 margin(2.0 * scene.settings.gate_px, 2.0 * scene.settings.gate_px);
  low -= margin;
  high += margin;
  double inside = 0.0;
  for (const LightSpot& s : spots) {
    if ((s.uv_px.array() >= low.array()).all() && (s.uv_px.array() <= high.array()).all()) inside += 1.0;
  }
  return std::max(1.0, inside - founders) / ((high.x() - low.x()) * (high.y() - low.y()));
}

/// Two cameras see the same lights: a light taken for a marker in one of them is met again in the other whenever its
/// distance happens to be right. The share of the target's depth, as disparity, in which it is.
double chance_in_depth(const SpotScene& scene, std::size_t camera, const Pose& pose, double noise_px) {
  double radius = 0.0;
  for (const TargetFeature& f : scene.target.features) {
    radius = std::max(radius, (f.p_T - scene.target.features[0].p_T).norm());
  }
  const RigCamera& k = scene.rig[camera];
  const double span_px = k.t_KC.norm() * k.model.intrinsics().fu * radius / pose.t_CT.squaredNorm();
  return std::min(0.5, 4.0 * noise_px / std::max(1e-9, span_px));
}

/// Fills in all but estimate and observations.
void judge(const SpotScene& scene, int poses_tried, SpotAgreement& out) {
  double by_chance = static_cast<double>(scene.rig.size());
  bool founded = false;
  int missing = 0;
  std::size_t spots = 0;
  out.expected = 0;
  for (std::size_t c = 0; c < scene.rig.size(); ++c) {
    Images images;
    predict(scene, c, out.estimate.pose, images);
    ChanceCount chance;
    std::uint64_t matched = 0;
    int hits = 0;
    for (const PoseObservation& o : out.observations) {
      if (o.camera != c) continue;
      matched |= std::uint64_t{1} << o.feature;
      ++hits;
    }
    const double around = density_around(scene, scene.spots[c], images, founded ? 0.0 : 3.0);
    const double noise_px = std::max(scene.settings.model_sigma_px, largest_residual_px(scene, out, c));
    const double in_depth = chance_in_depth(scene, c, out.estimate.pose, noise_px);
    for (std::size_t m = 0; m < scene.target.features.size(); ++m) {
      const bool has_spot = (matched >> m & 1U) != 0;
      if (images.expected[m]) ++out.expected;
      if (images.expected[m] && !has_spot) ++missing;
      if (!images.expected[m] && !has_spot) continue;
      const double p = reach * pi * noise_px * noise_px * density_at(scene.spots[c], images.uv_px[m], around);
      chance.add(founded ? std::max(p, in_depth) : p);
    }
    // Three spots of the first camera are met by construction; to be careful, those that chance would have met least.
    const bool founds = !founded && hits >= 3;
    by_chance *= chance.tail(founds ? 3 : 0, founds ? hits - 3 : hits);
    founded = founded || founds;
    spots += scene.spots[c].size();
  }
  const auto matched = static_cast<int>(out.observations.size());
  out.false_alarms = founded ? static_cast<double>(std::max(1, poses_tried)) * by_chance : no_foundation;
  out.whole = missing == 0 && out.observations.size() == spots;
  out.cost = out.estimate.chi2 - scene.settings.spot_worth * static_cast<double>(matched) +
             scene.settings.missing_cost * static_cast<double>(missing);
}

}  // namespace

Status refine_hypothesis(const SpotScene& scene, const Pose& start, int poses_tried, PoseObservations& previous,
                         SpotAgreement& out) {
  ObservationMask all;
  all.fill(true);
  Pose pose = start;
  bool settled = false;
  for (int k = 0; k < most_solutions && !settled; ++k) {
    // Wide, half as wide, then that of the noise.
    const double gate_px = k == 0 ? scene.settings.gate_px : (k == 1 ? 0.5 * scene.settings.gate_px : 0.0);
    previous = out.observations;
    assign_all(scene, pose, gate_px, out.observations);
    settled = k > 2 && are_equal(previous, out.observations);
    if (settled) break;
    if (out.observations.size() < least_spots) return Status::too_few_features;
    const Status status =
        solve_pose(scene.rig, scene.target, out.observations, all, pose, scene.settings.solver, out.estimate);
    if (status != Status::ok) return status;
    pose = out.estimate.pose;
  }
  if (!settled || !is_allowed(scene, pose)) return Status::no_convergence;
  if (!(out.estimate.chi2 <= scene.settings.chi2_factor * chi2_99(out.estimate.degrees_of_freedom))) {
    return Status::no_convergence;
  }
  judge(scene, poses_tried, out);
  return Status::ok;
}

bool are_same_pose(const PoseEstimate& a, const PoseEstimate& b) {
  // |R_a - R_b|_F^2 = 8 sin^2(angle / 2)
  const double angle2 = 0.5 * (a.pose.R_CT - b.pose.R_CT).squaredNorm();
  const double shift2 = (a.pose.t_CT - b.pose.t_CT).squaredNorm();
  const double turn = 0.02 + 3.0 * std::sqrt(std::max(0.0, a.covariance.diagonal().tail<3>().maxCoeff()));
  const double shift =
      0.02 * a.pose.t_CT.norm() + 3.0 * std::sqrt(std::max(0.0, a.covariance.diagonal().head<3>().maxCoeff()));
  return angle2 < std::min(turn, 0.2) * std::min(turn, 0.2) && shift2 < shift * shift;
}

}  // namespace relnav
