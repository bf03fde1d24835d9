#pragma once
#include "fsw/base/status.hpp"
#include "fsw/math/types.hpp"
#include "fsw/vision/image_view.hpp"
#include "fsw/vision/patch.hpp"

namespace relnav::vision {

struct SubpixelOptions {
  int max_iterations = 8;
  double max_move_px = 1.0;     ///< from the integer peak, in u or v
  double max_score_loss = 0.1;  ///< of the final correlation against the integer peak's
  int min_pixels = 32;          ///< not over-exposed, of window_pixels
  /// What is stated over the Cramer-Rao figure, which takes the residuals for white noise; they are mostly changes of
  /// appearance. 2.5 is measured against the true epipolar lines of four rendered sequences.
  double sigma_scale = 2.5;
  double min_sigma_px = 0.1;
  double max_sigma_px = 2.0;
  bool quadratic_fallback = true;   ///< else a position that Gauss-Newton does not determine is refused
  double quadratic_sigma_px = 0.6;  ///< stated for a position from the quadratic fit
};

struct SubpixelResult {
  Vec2 uv_px = Vec2::Zero();
  double sigma_px = 0.0;  ///< square root of the larger eigenvalue of the position's covariance, clamped
  double score = 0.0;     ///< correlation at uv over the pixels used
  int iterations = 0;
  bool quadratic = false;  ///< from the fit of the correlation surface
};

/// Refines an integer correlation peak (u, v) with correlation `score`: Gauss-Newton over the shift with gain and bias of
/// brightness, gradients of the patch (inverse compositional Lucas-Kanade, Baker, Matthews, IJCV 56(3), 2004); over-exposed
/// pixels of either image are left out. sigma: sigma_scale times Cramer-Rao (residual variance, inverse normal matrix).
/// Where that is not determined: parabolas through the correlations of the neighbours.
/// no_convergence: moved too far or correlates worse; rank_deficient: neither way gives a position.
[[nodiscard]] Status refine(const WarpedPatch& patch, const ImageView& image, int u_px, int v_px, double score,
                            const SubpixelOptions& options, SubpixelResult& result);

}  // namespace relnav::vision
