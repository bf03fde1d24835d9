#pragma once
#include <cstdint>

#include "fsw/estimation/attitude_state.hpp"
#include "fsw/estimation/motion_model.hpp"
#include "fsw/estimation/one_point_ransac.hpp"

namespace relnav {

enum class MotionKind : std::uint8_t { rigid_target, camera };

/// What the filter believes before the first frame and about the motion in between. Lengths and velocities are given
/// per metre of start range, because monocular scale is free.
struct NoncoopConfig {
  MotionKind motion = MotionKind::rigid_target;
  AttitudeChartKind chart = AttitudeChartKind::mrp;
  InertiaRatios inertia;       ///< of a rigid target; equal moments: its rate is constant
  double range_m = 1.0;        ///< start range along the line of sight; sets the free scale
  double range_sigma_m = 0.0;  ///< its 1 sigma: common to every length of the solution

  double rate_sigma_rad_s = 0.0;            ///< of the start rate (mean zero), each axis
  double velocity_sigma_per_range = 0.0;    ///< of the start velocity, 1/s
  double acceleration_psd_per_range = 0.0;  ///< s^-1.5
  double angular_psd = 0.0;                 ///< rad/s^1.5
  double relief_per_extent = 0.0;           ///< depth spread of the target over its apparent half width
  double min_relief = 0.0;                  ///< floor of the relative depth spread

  double pixel_sigma_px = 0.3;       ///< matching error that the front end's own sigma does not see
  double first_view_sigma_px = 0.1;  ///< how well a patch's first view tells where its point is
  /// Apparent motion of features over the target as it turns: glints slide, shading changes. Variance per angle turned.
  double feature_walk_px2_per_deg = 0.0;
  double robust_sigma = 0.0;          ///< innovation, in sigmas, that doubles a match's variance; 0: none does
  double gate_chi2 = 9.21;            ///< 99 %, two degrees of freedom
  double linearity_threshold = 0.04;  ///< L_d under which a feature becomes Euclidean (the paper's 0.1 is too early)
  int start_frames = 16;              ///< the start is adjusted over at least so many frames
  double start_duration_s = 5.25;     ///< and at least this long; three times both if it is not decided by then
  double start_angular_psd = 0.0;     ///< rad/s^1.5: how much the rate may change while the start is adjusted
  double start_pixel_sigma_px = 0.1;  ///< matching error over the start
  double rest_sigma_rad_s = 0.0;      ///< start rate of a target that hardly turns
  RansacConfig ransac;
  std::uint64_t seed = 1;

  /// Defaults per motion model; the caller sets range.
  [[nodiscard]] static NoncoopConfig defaults(MotionKind motion);
  /// invalid_argument: range, matching sigma, gate or a RANSAC setting not positive, confidence outside (0, 1), a sigma
  /// negative or not finite, moments of inertia that no body has; for a rigid target also a start sigma that is zero.
  [[nodiscard]] Status validate() const;
};

}  // namespace relnav
