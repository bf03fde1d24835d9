#pragma once
// Images of lamps as a camera takes them: point spread, integration over the pixels and the exposure, noise, saturation.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "fsw/vision/image_view.hpp"
#include "tests/support/normal.hpp"

namespace relnav::vision::test {

inline constexpr double lamp_psf_px = 0.75;     // 1 sigma of the point spread
inline constexpr double lamp_gain = 150.0;      // electrons a DN
inline constexpr double lamp_read_noise = 0.4;  // DN

struct Lamp {
  double u = 0.0;
  double v = 0.0;
  double radius = 0.0;     // of the disc, px; 0: a point
  double amplitude = 0.0;  // DN of a disc wider than the point spread; of a point: of the peak
  double streak_u = 0.0;   // path in the exposure, px
  double streak_v = 0.0;
};

/// Sum of point images over a disc, each integrated over the pixels exactly; levels in DN, not clipped.
class LampScene {
 public:
  LampScene(int width, int height, double background)
      : width_(width), levels_(static_cast<std::size_t>(width * height), background) {}

  void add(const Lamp& lamp) {
    const double path = std::hypot(lamp.streak_u, lamp.streak_v);
    if (path > 0.0) {
      const int parts = static_cast<int>(std::ceil(path / 0.5));
      for (int i = 0; i < parts; ++i) {
        const double from_middle = (i + 0.5) / parts - 0.5;
        add({lamp.u + from_middle * lamp.streak_u, lamp.v + from_middle * lamp.streak_v, lamp.radius,
             lamp.amplitude / parts});
      }
      return;
    }
    const int rings = lamp.radius > 0.0 ? static_cast<int>(std::ceil(lamp.radius / 0.2)) : 0;
    if (rings == 0) {
      add_point(lamp.u, lamp.v, lamp.amplitude * 2.0 * std::numbers::pi * lamp_psf_px * lamp_psf_px);
      return;
    }
    const double step_px = lamp.radius / rings;
    for (int i = 0; i < rings; ++i) {
      const double r = (i + 0.5) * step_px;
      const int parts = 6 * (2 * i + 1);
      const double flux = lamp.amplitude * 2.0 * std::numbers::pi * r * step_px / parts;
      for (int k = 0; k < parts; ++k) {
        const double angle = 2.0 * std::numbers::pi * (k + 0.3) / parts;
        add_point(lamp.u + r * std::cos(angle), lamp.v + r * std::sin(angle), flux);
      }
    }
  }

  /// With the camera's noise, clipped; DN times `factor`.
  template <typename Pixel>
  std::vector<Pixel> expose(relnav::test::Normal* noise, double factor = 1.0, double full_scale = 255.0) const {
    std::vector<Pixel> pixels(levels_.size());
    for (std::size_t i = 0; i < levels_.size(); ++i) {
      double level = levels_[i];
      if (noise != nullptr) level += std::sqrt(lamp_read_noise * lamp_read_noise + level / lamp_gain) * (*noise)();
      pixels[i] = static_cast<Pixel>(factor * std::clamp(std::floor(level + 0.5), 0.0, full_scale));
    }
    return pixels;
  }
  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return static_cast<int>(levels_.size()) / width_; }
  [[nodiscard]] double& at(int u, int v) { return levels_[static_cast<std::size_t>(v * width_ + u)]; }

 private:
  static double step(double x) { return 0.5 * (1.0 + std::erf(x / std::sqrt(2.0))); }

  void add_point(double u, double v, double flux) {
    constexpr int reach = 5;
    const int uc = static_cast<int>(std::lround(u));
    const int vc = static_cast<int>(std::lround(v));
    std::array<double, 2 * reach + 1> along{};
    for (int k = -reach; k <= reach; ++k) {
      along[static_cast<std::size_t>(k + reach)] =
          step((uc + k + 0.5 - u) / lamp_psf_px) - step((uc + k - 0.5 - u) / lamp_psf_px);
    }
    for (int y = std::max(vc - reach, 0); y <= std::min(vc + reach, height() - 1); ++y) {
      const double across = flux * (step((y + 0.5 - v) / lamp_psf_px) - step((y - 0.5 - v) / lamp_psf_px));
      for (int x = std::max(uc - reach, 0); x <= std::min(uc + reach, width_ - 1); ++x) {
        at(x, y) += across * along[static_cast<std::size_t>(x - uc + reach)];
      }
    }
  }

  int width_;
  std::vector<double> levels_;
};

template <typename Pixel>
GreyImageView<Pixel> view_of(const LampScene& scene, const std::vector<Pixel>& pixels) {
  return {pixels.data(), scene.width(), scene.height(), scene.width()};
}

}  // namespace relnav::vision::test
