#include "hil/simulation/feature_sensor.hpp"

#include <algorithm>
#include <cmath>

namespace relnav::hil {
namespace {

/// A face is trackable up to 75 deg off its normal.
constexpr double least_cosine = 0.26;
/// A patch needs room around its centre.
constexpr double patch_border_px = 12.5;
constexpr double least_sigma_px = 0.01;

/// Whether a point on a box about the origin of T is hidden by it (slab test; Kay, Kajiya, SIGGRAPH 1986).
bool is_hidden(const Vec3& p_T, const Vec3& camera_T, const Vec3& half_size_m) {
  constexpr double shrunk = 0.999;  // the point itself lies on the surface
  double enter = 0.0;
  double leave = 1.0;
  const Vec3 way = p_T - camera_T;
  for (int axis = 0; axis < 3; ++axis) {
    const double half = shrunk * half_size_m(axis);
    if (way(axis) == 0.0) {
      if (std::abs(camera_T(axis)) >= half) return false;
      continue;
    }
    const double a = (-half - camera_T(axis)) / way(axis);
    const double b = (half - camera_T(axis)) / way(axis);
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
  }
  return enter < leave;
}

}  // namespace

std::vector<SurfacePoint> surface_points(const FeatureSettings& settings, std::uint64_t seed) {
  Gaussian random(seed);
  std::vector<SurfacePoint> points;
  const Vec3& half = settings.half_size_m;
  for (int i = 0; i < settings.body_points; ++i) {
    const int face = std::min(5, static_cast<int>(random.uniform(0.0, 6.0)));
    const int axis = face / 2;
    const double side = face % 2 == 0 ? 1.0 : -1.0;
    SurfacePoint point;
    for (int k = 0; k < 3; ++k) point.p_T(k) = half(k) * random.uniform(-1.0, 1.0);
    point.p_T(axis) = side * half(axis) * (1.0 + 0.15 * random.next());
    point.normal_T(axis) = side;
    points.push_back(point);
  }
  return points;
}

SurfaceSensor::SurfaceSensor(const FeatureSettings& settings, const CameraModel& camera, std::uint64_t seed)
    : settings_(settings), camera_(camera), points_(surface_points(settings, seed)), random_(seed + 1) {}

bool SurfaceSensor::see(std::size_t point, const SceneState& truth, Vec2& uv_px) const {
  const Vec3 p_C = truth.R_CT * points_[point].p_T + truth.t_CT;
  const Vec3 n_C = truth.R_CT * points_[point].normal_T;
  if (-n_C.dot(p_C) < least_cosine * p_C.norm()) return false;
  return camera_.project(p_C, uv_px) == Status::ok && camera_.in_image(uv_px, patch_border_px);
}

bool SurfaceSensor::in_use(std::size_t point) const {
  return std::any_of(point_of_.begin(), point_of_.end(),
                     [&](const Entry& e) { return e.point == static_cast<int>(point); });
}

Vec2 SurfaceSensor::noise(double sigma_px) {
  const double du = random_.next();
  const double dv = random_.next();
  return sigma_px * Vec2(du, dv);
}

Status SurfaceSensor::start(NoncoopFilter& filter, Time time, const SceneState& truth, std::size_t least) {
  // As NoncoopNavigator does with corners: to the middle of what is seen, and its half width along the shorter axis.
  Vec2 sum = Vec2::Zero();
  Mat2 sum2 = Mat2::Zero();
  double count = 0.0;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    Vec2 uv_px;
    Vec3 ray_C;
    if (!see(i, truth, uv_px) || camera_.unproject(uv_px, ray_C) != Status::ok || !(ray_C.z() > 0.0)) continue;
    const Vec2 xy = ray_C.head<2>() / ray_C.z();
    sum += xy;
    sum2 += xy * xy.transpose();
    count += 1.0;
  }
  if (count < static_cast<double>(least)) return Status::too_few_features;
  const Vec2 mean = sum / count;
  const Mat2 scatter = sum2 / count - mean * mean.transpose();
  const double half_sum = 0.5 * (scatter(0, 0) + scatter(1, 1));
  const double root = std::hypot(0.5 * (scatter(0, 0) - scatter(1, 1)), scatter(0, 1));
  point_of_.fill({});
  filter.start(time, Vec3(mean(0), mean(1), 1.0).normalized(), std::sqrt(std::max(0.0, 2.0 * (half_sum - root))));
  add_features(filter, truth);
  filter.add_scale_uncertainty();
  return Status::ok;
}

void SurfaceSensor::add_features(NoncoopFilter& filter, const SceneState& truth) {
  const auto most = static_cast<std::size_t>(settings_.count);
  const std::size_t first = static_cast<std::size_t>(random_.uniform(0.0, static_cast<double>(points_.size())));
  // From a random point on, in steps that reach each of them: new features come from all over the target.
  constexpr std::size_t step = 7919;
  for (std::size_t k = 0; k < points_.size() && filter.has_room() && filter.state().features().size() < most; ++k) {
    const std::size_t i = (first + k * step) % points_.size();
    Vec2 uv_px;
    if (in_use(i) || !see(i, truth, uv_px)) continue;
    const Expected<SlotHandle> slot = filter.add_feature(uv_px + noise(settings_.first_view_sigma_px));
    if (slot) point_of_[slot.value().index] = {slot.value(), static_cast<int>(i)};
  }
}

void SurfaceSensor::measure(const FeaturePredictions& predictions, const SceneState& truth, FeatureMatches& matches) {
  matches.clear();
  for (const FeaturePrediction& p : predictions) {
    const Entry& entry = point_of_[p.slot.index];
    if (!(entry.slot == p.slot) || entry.point < 0) continue;
    FeatureMatch match;
    if (!see(static_cast<std::size_t>(entry.point), truth, match.uv_px)) continue;
    match.uv_px += noise(settings_.sigma_px);
    const double luck = random_.uniform(0.0, 1.0);
    if (luck < settings_.missed_share) continue;
    if (luck < settings_.missed_share + settings_.outlier_share) {
      const double du = random_.uniform(-1.0, 1.0);
      const double dv = random_.uniform(-1.0, 1.0);
      match.uv_px += settings_.outlier_px * Vec2(du, dv);
    }
    match.slot = p.slot;
    match.sigma_px = least_sigma_px;  // the filter adds its own pixel_sigma_px
    match.score = 1.0;
    if (matches.push_back(match) != Status::ok) return;
  }
}

void SurfaceSensor::forget(SlotHandle slot) {
  if (point_of_[slot.index].slot == slot) point_of_[slot.index].point = -1;
}

LightSensor::LightSensor(const FeatureSettings& settings, const CameraRig& rig, const TargetModel& target,
                         std::uint64_t seed)
    : settings_(settings), rig_(rig), target_(target), random_(seed) {}

PoseObservations LightSensor::observe(const SceneState& truth) {
  PoseObservations observations;
  for (std::size_t c = 0; c < rig_.size(); ++c) {
    for (std::size_t f = 0; f < target_.features.size(); ++f) {
      const TargetFeature& feature = target_.features[f];
      const Vec3 p_C = truth.R_CT * feature.p_T + truth.t_CT;
      const Vec3 p_K = rig_[c].R_KC * p_C + rig_[c].t_KC;
      const double du = random_.next();
      const double dv = random_.next();
      const double luck = random_.uniform(0.0, 1.0);
      if (!feature.normal_T.isZero() && (rig_[c].R_KC * (truth.R_CT * feature.normal_T)).dot(p_K) >= 0.0) continue;
      const Vec3 camera_T = truth.R_CT.transpose() * (rig_[c].R_KC.transpose() * -rig_[c].t_KC - truth.t_CT);
      if (settings_.opaque_body && is_hidden(feature.p_T, camera_T, settings_.half_size_m)) continue;
      PoseObservation o;
      if (rig_[c].model.project(p_K, o.uv_px) != Status::ok) continue;
      o.uv_px += settings_.sigma_px * Vec2(du, dv);
      if (luck < settings_.missed_share) continue;
      if (luck < settings_.missed_share + settings_.outlier_share) {
        const double eu = random_.uniform(-1.0, 1.0);
        const double ev = random_.uniform(-1.0, 1.0);
        o.uv_px += settings_.outlier_px * Vec2(eu, ev);
      }
      if (!rig_[c].model.in_image(o.uv_px)) continue;
      o.camera = static_cast<std::uint16_t>(c);
      o.feature = static_cast<std::uint16_t>(f);
      o.sigma_px = std::max(settings_.sigma_px, least_sigma_px);
      if (observations.push_back(o) != Status::ok) return observations;
    }
  }
  return observations;
}

}  // namespace relnav::hil
