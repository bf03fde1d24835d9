#include "fsw/estimation/noncoop_config.hpp"

#include <cmath>

namespace relnav {
namespace {

constexpr double deg = 0.017453292519943295;

[[nodiscard]] bool is_positive(double value) { return std::isfinite(value) && value > 0.0; }
[[nodiscard]] bool is_valid_sigma(double sigma) { return std::isfinite(sigma) && sigma >= 0.0; }

}  // namespace

NoncoopConfig NoncoopConfig::defaults(MotionKind motion) {
  NoncoopConfig c;
  c.motion = motion;
  if (motion == MotionKind::rigid_target) {
    c.rate_sigma_rad_s = 3.0 * deg;
    c.velocity_sigma_per_range = 0.05;
    c.acceleration_psd_per_range = 0.0005;
    c.angular_psd = 0.02 * deg;
    c.start_angular_psd = 0.1 * deg;
    c.rest_sigma_rad_s = 0.15 * deg;
    c.relief_per_extent = 1.0;
    c.min_relief = 0.03;
    c.pixel_sigma_px = 0.33;
    c.feature_walk_px2_per_deg = 0.015;
    c.robust_sigma = 1.0;
  } else {
    c.rate_sigma_rad_s = 0.5;
    c.velocity_sigma_per_range = 0.5;
    c.acceleration_psd_per_range = 0.5;
    c.angular_psd = 0.7;
    c.relief_per_extent = 0.0;
    c.min_relief = 0.85;
    c.first_view_sigma_px = 0.25;
  }
  return c;
}

Status NoncoopConfig::validate() const {
  bool valid = is_positive(range_m) && is_valid_sigma(range_sigma_m) && is_valid_sigma(rate_sigma_rad_s) &&
               is_valid_sigma(velocity_sigma_per_range) && is_valid_sigma(acceleration_psd_per_range) &&
               is_valid_sigma(angular_psd) && is_valid_sigma(relief_per_extent) && is_valid_sigma(min_relief) &&
               is_positive(pixel_sigma_px) && is_positive(first_view_sigma_px) &&
               is_valid_sigma(feature_walk_px2_per_deg) && is_valid_sigma(robust_sigma) && is_positive(gate_chi2) &&
               is_valid_sigma(linearity_threshold) && is_valid_sigma(start_duration_s) && start_frames > 0 &&
               ransac.confidence > 0.0 && ransac.confidence < 1.0 && is_positive(ransac.threshold_sigma) &&
               ransac.max_hypotheses > 0 && inertia.is_physical();
  if (motion == MotionKind::rigid_target) {
    // The start adjustment divides by these.
    valid = valid && is_positive(rate_sigma_rad_s) && is_positive(velocity_sigma_per_range) &&
            is_positive(min_relief) && is_positive(start_angular_psd) && is_positive(start_pixel_sigma_px) &&
            is_positive(rest_sigma_rad_s);
  }
  return valid ? Status::ok : Status::invalid_argument;
}

}  // namespace relnav
