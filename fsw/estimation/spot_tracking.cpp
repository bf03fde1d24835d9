#include "fsw/estimation/spot_tracking.hpp"

#include <cmath>

#include "fsw/attitude/so3.hpp"

namespace relnav {

void expect_markers(const CameraRig& rig, const TargetModel& target, const Pose& pose, const Mat6& pose_covariance,
                    std::uint16_t camera, double border_px, const SpotTrackingSettings& settings,
                    ExpectedMarkers& markers) {
  const RigCamera& seen_by = rig[camera];
  const Vec3 centre_T = camera_centre_T(in_camera(seen_by, pose));
  for (std::size_t i = 0; i < target.features.size(); ++i) {
    const TargetFeature& f = target.features[i];
    if (!faces(f, centre_T, settings.least_cosine)) continue;
    const Vec3 X_r = pose.R_CT * f.p_T;
    ExpectedMarker m;
    Mat23 J_uv_p;
    if (seen_by.model.project(Vec3(seen_by.R_KC * (X_r + pose.t_CT) + seen_by.t_KC), m.uv_px, J_uv_p) != Status::ok) {
      continue;
    }
    if (!seen_by.model.in_image(m.uv_px, border_px)) continue;
    m.feature = static_cast<std::uint16_t>(i);
    m.camera = camera;
    Mat<2, 6> J;  // of [dt dphi]
    J.leftCols<3>() = J_uv_p * seen_by.R_KC;
    J.rightCols<3>() = -(J.leftCols<3>() * cross_matrix(X_r));
    const Mat<2, 6> JP = J.lazyProduct(pose_covariance);
    m.S_px2 = JP.lazyProduct(J.transpose());
    if (markers.push_back(m) != Status::ok) return;  // as many places as features and cameras: cannot be
  }
}

void assign_spots(const ExpectedMarkers& markers, const RigSpots& spots, const SpotTrackingSettings& settings,
                  SpotAssignment& out) {
  out.observations.clear();
  out.marker.clear();
  std::array<std::array<bool, config::max_spots>, config::max_cameras> taken{};
  std::array<bool, config::max_observations> served{};
  const double floor2 = settings.floor_sigma_px * settings.floor_sigma_px;
  // Nearest pair first, as often as there are markers.
  for (std::size_t round = 0; round < markers.size(); ++round) {
    double least = settings.gate_chi2;
    std::size_t best_marker = markers.size();
    std::size_t best_spot = 0;
    for (std::size_t k = 0; k < markers.size(); ++k) {
      if (served[k]) continue;
      const ExpectedMarker& m = markers[k];
      const LightSpots& of_camera = spots[m.camera];
      for (std::size_t s = 0; s < of_camera.size(); ++s) {
        if (taken[m.camera][s]) continue;
        const Vec2 d = of_camera[s].uv_px - m.uv_px;
        const double noise2 = floor2 + of_camera[s].sigma_px * of_camera[s].sigma_px;
        const double a = m.S_px2(0, 0) + noise2;
        const double b = m.S_px2(1, 1) + noise2;
        const double c = m.S_px2(0, 1);
        const double determinant = a * b - c * c;
        const double d2 = (b * d(0) * d(0) - 2.0 * c * d(0) * d(1) + a * d(1) * d(1)) / determinant;
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
    if (out.observations.push_back(o) != Status::ok ||
        out.marker.push_back(static_cast<std::uint16_t>(best_marker)) != Status::ok) {
      return;
    }
  }
}

}  // namespace relnav
