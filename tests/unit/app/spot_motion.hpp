#pragma once
// Light spots of a target in constant motion, as one or two cameras see them.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "fsw/vision/image_view.hpp"
#include "fsw/vision/spot_profile.hpp"
#include "tests/unit/estimation/spot_simulation.hpp"

namespace relnav::test {

inline constexpr int spot_width_px = 640;
inline constexpr int spot_height_px = 480;
inline constexpr double spot_step_s = 0.1;

class SpotImage {
 public:
  SpotImage() : levels_(static_cast<std::size_t>(spot_width_px * spot_height_px), 8.0), pixels_(levels_.size(), 8) {}
  /// Disc of 1.5 px radius behind the finder's point spread.
  void draw(const Vec2& uv_px) {
    const int u0 = static_cast<int>(uv_px(0)), v0 = static_cast<int>(uv_px(1));
    for (int v = std::max(0, v0 - 6); v <= std::min(spot_height_px - 1, v0 + 6); ++v) {
      for (int u = std::max(0, u0 - 6); u <= std::min(spot_width_px - 1, u0 + 6); ++u) {
        const double r = (Vec2(u, v) - uv_px).norm();
        const double level = 190.0 * vision::spot_profile(r, 1.5, 1.0 / 0.75).level;
        const auto i = static_cast<std::size_t>(v * spot_width_px + u);
        levels_[i] = std::min(255.0, levels_[i] + level);
        pixels_[i] = static_cast<std::uint8_t>(levels_[i] + 0.5);
      }
    }
  }
  /// Rows from `row` on are those of `other`.
  void take_rows_of(const SpotImage& other, int row) {
    const auto first = static_cast<std::ptrdiff_t>(row) * spot_width_px;
    std::copy(other.levels_.begin() + first, other.levels_.end(), levels_.begin() + first);
    std::copy(other.pixels_.begin() + first, other.pixels_.end(), pixels_.begin() + first);
  }
  [[nodiscard]] const std::vector<std::uint8_t>& pixels() const { return pixels_; }
  [[nodiscard]] vision::ImageView view() const {
    return {pixels_.data(), spot_width_px, spot_height_px, spot_width_px};
  }
  /// The same light in so many bits, unscaled.
  [[nodiscard]] std::vector<std::uint16_t> deeper(int bits) const {
    std::vector<std::uint16_t> deep(levels_.size());
    const double factor = ((1 << bits) - 1) / 255.0;
    for (std::size_t i = 0; i < deep.size(); ++i) deep[i] = static_cast<std::uint16_t>(factor * levels_[i] + 0.5);
    return deep;
  }

 private:
  std::vector<double> levels_;
  std::vector<std::uint8_t> pixels_;
};

/// A target in constant motion and the images of it.
struct SpotMotion {
  CameraRig rig;
  TargetModel target;
  Pose pose{exp_so3(Vec3(0.15, -0.2, 0.3)), Vec3(-0.3, 0.2, 6.0)};
  Vec3 v_C = Vec3(0.05, -0.03, -0.1);
  Vec3 omega_C = Vec3(0.03, -0.02, 0.05);
  std::array<SpotImage, config::max_cameras> images;

  /// Without the markers of `hidden`; `clutter`: a spot that is none of the target's.
  void render(const std::vector<std::size_t>& hidden = {}, const std::vector<Vec2>& clutter = {}) {
    for (std::size_t c = 0; c < rig.size(); ++c) {
      images[c] = SpotImage();
      for (const Vec2& uv : clutter) images[c].draw(uv);
      for (std::size_t i = 0; i < target.features.size(); ++i) {
        if (std::find(hidden.begin(), hidden.end(), i) != hidden.end()) continue;
        Vec2 uv_px;
        const Pose in_camera_pose = in_camera(rig[c], pose);
        const Vec3 p = in_camera_pose.R_CT * target.features[i].p_T + in_camera_pose.t_CT;
        if (rig[c].model.project(p, uv_px) == Status::ok) images[c].draw(uv_px);
      }
    }
  }
  void render_nothing() { images.fill(SpotImage()); }
  void advance() {
    pose.t_CT += spot_step_s * v_C;
    pose.R_CT = exp_so3(Vec3(spot_step_s * omega_C)) * pose.R_CT;
  }
};

}  // namespace relnav::test
