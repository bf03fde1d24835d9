#pragma once
// A box with faces of random patches, turning and moving at constant rates before a pinhole camera: rendered images with
// exact truth. Deterministic: the same seed and frame give the same pixels.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "fsw/attitude/so3.hpp"
#include "fsw/base/generator.hpp"
#include "fsw/geometry/camera_model.hpp"
#include "fsw/math/types.hpp"

namespace relnav::test {

struct BoxMotion {
  Vec3 t_CB0 = Vec3(0.0, 0.0, 3.0);
  Vec3 v_C = Vec3(0.0, 0.0, 0.0);
  Vec3 omega_C = Vec3(0.02, 0.05, -0.03);  ///< rad/s
  Vec3 phi0 = Vec3(0.4, 0.5, 0.1);         ///< attitude at the start
};

class RenderedBox {
 public:
  static constexpr int width_px = 320;
  static constexpr int height_px = 240;
  using Pixels = std::vector<std::uint8_t>;

  explicit RenderedBox(std::uint64_t seed, const BoxMotion& motion = {}) : seed_(seed), motion_(motion) {
    Generator generator(seed);
    for (auto& face : levels_) {
      for (auto& level : face) level = 30 + static_cast<int>(generator.below(200));
    }
  }

  [[nodiscard]] static CameraIntrinsics camera() {
    CameraIntrinsics c;
    c.fu = c.fv = 330.0;
    c.cu = 159.5;
    c.cv = 119.5;
    c.width_px = width_px;
    c.height_px = height_px;
    return c;
  }

  [[nodiscard]] Mat3 R_CB(double t_s) const { return exp_so3(Vec3(t_s * motion_.omega_C)) * exp_so3(motion_.phi0); }
  [[nodiscard]] Vec3 t_CB(double t_s) const { return motion_.t_CB0 + t_s * motion_.v_C; }

  /// Four rays a pixel, noise of up to two levels that differs from frame to frame.
  [[nodiscard]] Pixels render(double t_s, std::uint32_t frame) const {
    Pixels pixels(static_cast<std::size_t>(width_px) * height_px);
    Generator noise(seed_ + 1, frame);
    const CameraIntrinsics c = camera();
    const Mat3 R_BC = R_CB(t_s).transpose();
    const Vec3 eye_B = -(R_BC * t_CB(t_s));
    for (int v = 0; v < height_px; ++v) {
      for (int u = 0; u < width_px; ++u) {
        int sum = 0;
        for (int k = 0; k < 4; ++k) {
          const double du = (k % 2 == 0) ? -0.25 : 0.25;
          const double dv = (k < 2) ? -0.25 : 0.25;
          sum += level(eye_B, R_BC * Vec3((u + du - c.cu) / c.fu, (v + dv - c.cv) / c.fv, 1.0));
        }
        const int noisy = sum / 4 + static_cast<int>(noise.below(5)) - 2;
        pixels[static_cast<std::size_t>(v) * width_px + static_cast<std::size_t>(u)] =
            static_cast<std::uint8_t>(std::clamp(noisy, 0, 255));
      }
    }
    return pixels;
  }

 private:
  static constexpr int cells = 14;
  static constexpr double half_m = 0.8;

  /// Grey level where a ray meets the box; black beside it.
  [[nodiscard]] int level(const Vec3& eye_B, const Vec3& ray_B) const {
    double enter = 0.0;
    double leave = 1e9;
    int face = -1;
    for (int axis = 0; axis < 3; ++axis) {
      const double inverse = 1.0 / ray_B(axis);
      const double a = (-half_m - eye_B(axis)) * inverse;
      const double b = (half_m - eye_B(axis)) * inverse;
      if (std::min(a, b) > enter) {
        enter = std::min(a, b);
        face = 2 * axis + (a < b ? 0 : 1);
      }
      leave = std::min(leave, std::max(a, b));
    }
    if (face < 0 || enter > leave) return 5;
    const Vec3 p_B = eye_B + enter * ray_B;
    const auto cell = [](double x) {
      return std::clamp(static_cast<int>((x + half_m) / (2.0 * half_m) * cells), 0, cells - 1);
    };
    const int i = cell(p_B((face / 2 + 1) % 3));
    const int j = cell(p_B((face / 2 + 2) % 3));
    return levels_[static_cast<std::size_t>(face)][static_cast<std::size_t>(i * cells + j)];
  }

  std::uint64_t seed_;
  BoxMotion motion_;
  std::array<std::array<int, static_cast<std::size_t>(cells* cells)>, 6> levels_{};
};

}  // namespace relnav::test
