#pragma once
#include <cstdint>
#include <vector>

#include "hil/render/worker_pool.hpp"

namespace relnav::hil {

/// What the lens makes of a point: a Gaussian, and a wide one around it that holds a small share (halo).
struct PointSpread {
  double sigma_px = 0.75;
  double halo_share = 0.01;
  double halo_sigma_px = 6.0;
};

/// Floats, rows top to bottom.
struct Plane {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::vector<float> values;

  void resize(std::uint32_t w, std::uint32_t h) {
    width = w;
    height = h;
    values.resize(static_cast<std::size_t>(w) * h);
  }
  [[nodiscard]] float* row(std::uint32_t v) { return values.data() + static_cast<std::size_t>(v) * width; }
  [[nodiscard]] const float* row(std::uint32_t v) const { return values.data() + static_cast<std::size_t>(v) * width; }
};

/// Spreads an image. Beyond its edges nothing shines in.
class PointSpreadFilter {
 public:
  PointSpreadFilter(const PointSpread& spread, std::uint32_t width, std::uint32_t height);

  /// `sharp` holds means over pixels. `points`: light that has its core drawn already (draw_point) and needs its halo; it is
  /// added to `out` as it is.
  void apply(const Plane& sharp, const Plane& points, WorkerPool& pool, Plane& out);

 private:
  PointSpread spread_;
  std::vector<float> core_;  // half of the kernel, from its centre
  std::vector<float> halo_;  // likewise, on the coarse grid
  Plane across_;
  Plane coarse_;
  Plane coarse_across_;
  Plane coarse_halo_;
};

/// Adds `energy` (sum over pixels) at (u, v), spread by a Gaussian of sigma_px and integrated over each pixel.
void draw_point(Plane& plane, double u, double v, double energy, double sigma_px);

}  // namespace relnav::hil
