#pragma once
#include "fsw/base/bounded_vector.hpp"
#include "fsw/estimation/spot_scene.hpp"

namespace relnav {

/// Where a marker is expected in an image.
struct ExpectedMarker {
  std::uint16_t feature = 0;  ///< position in TargetModel::features
  std::uint16_t camera = 0;
  Vec2 uv_px = Vec2::Zero();
  Mat2 S_px2 = Mat2::Identity();  ///< of the prediction alone, from the pose's covariance
  bool in_sight = true;           ///< by the frames before (MarkerSights)
  double flux = 0.0;              ///< when last in sight, as LightSpot has it; 0: not known
};
using ExpectedMarkers = BoundedVector<ExpectedMarker, config::max_observations>;

struct SpotTrackingSettings {
  double gate_chi2 = 16.0;       ///< two degrees of freedom, 3e-4
  double floor_sigma_px = 0.7;   ///< added to the prediction: the target does not move quite as the filter thinks
  double agreement_chi2 = 16.0;  ///< likewise: of a spot that agrees with a solved pose
  double flux_ratio = 2.0;  ///< up or down from frame to frame: beyond, part of the light is hidden, or it is another
  double model_sigma_px = 0.03;  ///< added to a spot's own sigma: markers are not quite where the model says
  double least_cosine = 0.1;     ///< of a face towards the camera; beyond it is not expected

  /// invalid_argument: outside of the domain.
  [[nodiscard]] Status check() const {
    const bool valid = gate_chi2 > 0.0 && floor_sigma_px > 0.0 && agreement_chi2 > 0.0 && flux_ratio > 1.0 &&
                       model_sigma_px >= 0.0 && least_cosine >= 0.0 && least_cosine < 1.0;
    return valid ? Status::ok : Status::invalid_argument;
  }
};

/// Squared Mahalanobis distance of an image offset: covariance S_px2 of the prediction, and noise2_px2 more on each axis.
[[nodiscard]] inline double mahalanobis2(const Vec2& d_px, const Mat2& S_px2, double noise2_px2) {
  const double a = S_px2(0, 0) + noise2_px2;
  const double b = S_px2(1, 1) + noise2_px2;
  const double c = S_px2(0, 1);
  return (b * d_px(0) * d_px(0) - 2.0 * c * d_px(0) * d_px(1) + a * d_px(1) * d_px(1)) / (a * b - c * c);
}

/// Markers of a predicted pose that the camera of `camera` should see: in front, inside the image by border_px, faces turned
/// towards it. Appended to `markers`.
void expect_markers(const CameraRig& rig, const TargetModel& target, const Pose& pose, const Mat6& pose_covariance,
                    std::uint16_t camera, double border_px, const SpotTrackingSettings& settings,
                    ExpectedMarkers& markers);

struct SpotAssignment {
  PoseObservations observations;
  BoundedVector<double, config::max_observations> flux;  ///< of each observation's spot
  BoundedVector<std::uint16_t, config::max_observations>
      marker;  ///< of each observation, position in the expected markers
};
enum class Markers : std::uint8_t { all, in_sight };
/// One-to-one assignment of spots to expected markers within the gate of a predicted pose, nearest pairs first. The
/// observations carry the spots' sigmas with model_sigma added.
void assign_spots(const ExpectedMarkers& markers, const RigSpots& spots, Markers which,
                  const SpotTrackingSettings& settings, SpotAssignment& out);
/// The same for markers expected by the pose that was solved in this frame: what lies within its noise.
void find_agreeing_spots(const ExpectedMarkers& markers, const RigSpots& spots, const SpotTrackingSettings& settings,
                         SpotAssignment& out);

}  // namespace relnav
