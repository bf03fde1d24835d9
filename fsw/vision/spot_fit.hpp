#pragma once
#include "fsw/base/status.hpp"
#include "fsw/math/types.hpp"
#include "fsw/vision/image_view.hpp"
#include "fsw/vision/spot_settings.hpp"

namespace relnav::vision {

/// Where a fit starts.
struct SpotSeed {
  Vec2 uv_px = Vec2::Zero();
  Vec2 half_streak_px = Vec2::Zero();  ///< from the middle to the end of the path in the exposure
  double area_px = 1.0;
  double peak_dn = 0.0;
};

struct SpotFit {
  Vec2 uv_px = Vec2::Zero();
  double sigma_px = 0.0;        ///< root of the mean variance of the coordinates
  double flux_dn = 0.0;         ///< sum of the levels above the background, saturated ones as they are
  double background_dn = 0.0;   ///< of the surroundings
  double amplitude_dn = 0.0;    ///< of the profile, beyond full scale where that is saturated
  double half_width_px = 0.0;   ///< R of the profile
  double half_length_px = 0.0;  ///< of the path in the exposure
  double misfit = 0.0;   ///< rms residual of the flank, outliers weighted down, over the level of the spot as seen
  double support = 0.0;  ///< part of the flank that is not weighted down as an outlier, 0..1
  int iterations = 0;
};

/// Fits background + amplitude * spot_profile to the pixels about the seed: at most max_iterations damped Gauss-Newton
/// steps, weights from the noise and an allowance for the profile's errors, outliers (neighbours) weighted down
/// (Geman-McClure). A saturated pixel says only that the model is not below full scale there: the flank carries the
/// position. The window ends three point spreads outside the spot. The background is held near the level of a ring about
/// the window.
/// sigma: noise through the weights (sandwich), residuals beyond noise times sigma_clutter, floor.
/// no_convergence: left the seed, or no bright spot there; rank_deficient: the pixels do not determine the spot.
[[nodiscard]] Status fit_spot(const ImageView& image, const SpotSettings& settings, const SpotSeed& seed, SpotFit& fit);
[[nodiscard]] Status fit_spot(const ImageView16& image, const SpotSettings& settings, const SpotSeed& seed,
                              SpotFit& fit);

}  // namespace relnav::vision
