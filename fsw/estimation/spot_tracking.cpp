#include "fsw/estimation/spot_tracking.hpp"

#include <cmath>

#include "fsw/geometry/marker_image.hpp"

namespace relnav {

void expect_markers(const CameraRig& rig, const TargetModel& target, const Pose& pose, const Mat6& pose_covariance,
                    std::uint16_t camera, double border_px, const SpotTrackingSettings& settings,
                    ExpectedMarkers& markers) {
  const RigCamera& seen_by = rig[camera];
  const Vec3 centre_T = camera_centre_T(in_camera(seen_by, pose));
  for (std::size_t i = 0; i < target.features.size(); ++i) {
    const TargetFeature& f = target.features[i];
    if (!faces(f, centre_T, settings.least_cosine)) continue;
    MarkerImage image;
    if (image_of(seen_by, f.p_T, pose, image) != Status::ok) continue;
    if (!seen_by.model.in_image(image.uv_px, border_px)) continue;
    ExpectedMarker m;
    m.uv_px = image.uv_px;
    m.feature = static_cast<std::uint16_t>(i);
    m.camera = camera;
    const Mat<2, 6> JP = image.J.lazyProduct(pose_covariance);
    m.S_px2 = JP.lazyProduct(image.J.transpose());
    if (markers.push_back(m) != Status::ok) return;  // as many places as features and cameras: cannot be
  }
}

namespace {

struct Gate {
  double floor_sigma_px;  ///< added to the prediction
  double chi2;
};

bool is_as_bright(const LightSpot& spot, const ExpectedMarker& marker, double ratio) {
  return !(marker.flux > 0.0) || (spot.flux < ratio * marker.flux && marker.flux < ratio * spot.flux);
}

void assign(const ExpectedMarkers& markers, const RigSpots& spots, Markers which, const Gate& gate,
            const SpotTrackingSettings& settings, SpotAssignment& out) {
  out.observations.clear();
  out.flux.clear();
  out.marker.clear();
  std::array<std::array<bool, config::max_spots>, config::max_cameras> taken{};
  std::array<bool, config::max_observations> served{};
  const double floor2 = gate.floor_sigma_px * gate.floor_sigma_px;
  // Nearest pair first, as often as there are markers.
  for (std::size_t round = 0; round < markers.size(); ++round) {
    double least = gate.chi2;
    std::size_t best_marker = markers.size();
    std::size_t best_spot = 0;
    for (std::size_t k = 0; k < markers.size(); ++k) {
      if (served[k] || (which == Markers::in_sight && !markers[k].in_sight)) continue;
      const ExpectedMarker& m = markers[k];
      const LightSpots& of_camera = spots[m.camera];
      for (std::size_t s = 0; s < of_camera.size(); ++s) {
        if (taken[m.camera][s] || !is_as_bright(of_camera[s], m, settings.flux_ratio)) continue;
        const Vec2 d = of_camera[s].uv_px - m.uv_px;
        const double noise2 = floor2 + of_camera[s].sigma_px * of_camera[s].sigma_px;
        const double d2 = mahalanobis2(d, m.S_px2, noise2);
        if (!(d2 < least)) continue;
        least = d2;
        best_marker = k;
        best_spot = s;
      }
    }
    if (best_marker == markers.size()) return;
    const ExpectedMarker& m = markers[best_marker];
    const LightSpot& spot = spots[m.camera][best_spot];
    served[best_marker] = true;
    taken[m.camera][best_spot] = true;
    PoseObservation o;
    o.feature = m.feature;
    o.camera = m.camera;
    o.uv_px = spot.uv_px;
    o.sigma_px = std::sqrt(spot.sigma_px * spot.sigma_px + settings.model_sigma_px * settings.model_sigma_px);
    if (out.observations.push_back(o) != Status::ok || out.flux.push_back(spot.flux) != Status::ok ||
        out.marker.push_back(static_cast<std::uint16_t>(best_marker)) != Status::ok) {
      return;
    }
  }
}

}  // namespace

void assign_spots(const ExpectedMarkers& markers, const RigSpots& spots, Markers which,
                  const SpotTrackingSettings& settings, SpotAssignment& out) {
  assign(markers, spots, which, {settings.floor_sigma_px, settings.gate_chi2}, settings, out);
}

void find_agreeing_spots(const ExpectedMarkers& markers, const RigSpots& spots, const SpotTrackingSettings& settings,
                         SpotAssignment& out) {
  assign(markers, spots, Markers::all, {settings.model_sigma_px, settings.agreement_chi2}, settings, out);
}

}  // namespace relnav
