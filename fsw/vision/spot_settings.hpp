#pragma once
#include "fsw/base/status.hpp"

namespace relnav::vision {

/// Camera, light and gate of the light-spot finder. Levels in DN of the image at hand.
struct SpotSettings {
  double full_scale_dn = 255.0;      ///< largest level; from here on a pixel counts as saturated
  double gain_electrons_dn = 150.0;  ///< electrons a DN
  double read_noise_dn = 0.4;        ///< 1 sigma
  double psf_sigma_px = 0.75;        ///< of the narrowest image of a point, integration over the pixel included

  double min_contrast = 0.1;     ///< of a spot's brightest pixel over the background, of full scale
  double noise_factor = 6.0;     ///< of a spot over the background, in sigmas of noise
  double clutter_factor = 2.0;   ///< of a spot over the background, in spreads of the background around
  int min_area_px = 2;           ///< above the level at which the region is judged
  int max_area_px = 300;         ///< likewise
  double max_elongation = 4.0;   ///< ratio of the axes of the region's second moments
  double min_fill = 0.75;        ///< area over the area of the ellipse of the same second moments
  double max_misfit = 0.25;      ///< rms residual of the fit over the level of the spot
  double min_support = 0.4;      ///< part of the flank that the fit explains
  double converged_px = 1e-3;    ///< step of the centre under which the fit has come to rest
  double sigma_floor_px = 0.02;  ///< what the model of the spot itself does not explain
  double sigma_clutter = 2.5;    ///< weight of the residuals that noise does not explain; they are not independent

  [[nodiscard]] Status check() const {
    const bool camera =
        full_scale_dn >= 1.0 && full_scale_dn <= 65535.0 && gain_electrons_dn > 0.0 && read_noise_dn >= 0.0;
    const bool gate = psf_sigma_px >= 0.3 && psf_sigma_px <= 3.0 && min_contrast > 0.0 && min_contrast < 1.0 &&
                      min_area_px >= 1 && max_area_px >= min_area_px && max_elongation >= 1.0;
    const bool factors = noise_factor >= 0.0 && clutter_factor >= 0.0 && sigma_floor_px >= 0.0 && converged_px > 0.0 &&
                         sigma_clutter >= 0.0 && max_misfit > 0.0 && min_fill >= 0.0;
    return camera && gate && factors ? Status::ok : Status::invalid_argument;
  }
};

}  // namespace relnav::vision
