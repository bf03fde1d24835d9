#pragma once
#include "fsw/estimation/spot_scene.hpp"

namespace relnav {

/// A pose refined with the spots it explains, and how much that says.
struct SpotAgreement {
  PoseEstimate estimate;
  PoseObservations observations;
  int expected = 0;   ///< images of markers on faces turned to a camera, within the picture
  double cost = 0.0;  ///< chi-square, less the worth of the spots explained, plus that of markers missed
  double false_alarms =
      0.0;             ///< number of poses this good to be expected among as many tried, if the spots lay at random
  bool whole = false;  ///< no marker without its spot, no spot without its marker
};

/// Refines a pose: one-to-one assignment within the gate, least squares, again within the gate of the noise, until it stays.
/// At most 5 solutions. `poses_tried`: by the search up to here.
/// ok; too_few_features: fewer than 4 spots; no_convergence: residuals beyond chi2_factor, the pose not allowed, or the
/// assignment does not come to rest; else as solve_pose().
/// `previous` is room to work in.
Status refine_hypothesis(const SpotScene& scene, const Pose& start, int poses_tried, PoseObservations& previous,
                         SpotAgreement& out);

/// The two are one solution within its uncertainty (and 1 deg, 2 % of range).
[[nodiscard]] bool are_same_pose(const PoseEstimate& a, const PoseEstimate& b);

}  // namespace relnav
