#pragma once
#include <cstdint>
#include <vector>

#include "fsw/geometry/camera_model.hpp"
#include "hil/render/vec3f.hpp"

namespace relnav::hil {

/// Viewing rays of all pixels, unprojected once through the flight code's camera model.
class RayTable {
 public:
  /// Throws std::invalid_argument without a camera.
  explicit RayTable(const CameraModel& camera);

  [[nodiscard]] std::uint32_t width() const { return width_; }
  [[nodiscard]] std::uint32_t height() const { return height_; }
  [[nodiscard]] bool is_seen(std::uint32_t u, std::uint32_t v) const { return angles_[at(u, v)] > 0.0F; }
  /// Unit vector in C through a pixel's centre.
  [[nodiscard]] Vec3f centre(std::uint32_t u, std::uint32_t v) const { return centres_C_[at(u, v)]; }
  /// And off its centre by (du, dv) pixels, at most one: to second order of a tiny angle, and not of unit length.
  [[nodiscard]] Vec3f off_centre(std::uint32_t u, std::uint32_t v, float du, float dv) const {
    const Slope& s = slopes_[at(u, v)];
    return centres_C_[at(u, v)] + du * s.along_u_C + dv * s.along_v_C;
  }
  /// Of a pixel, rad: the square root of its solid angle.
  [[nodiscard]] float pixel_angle(std::uint32_t u, std::uint32_t v) const { return angles_[at(u, v)]; }

 private:
  struct Slope {  // derivatives of the unit vector
    Vec3f along_u_C;
    Vec3f along_v_C;
  };
  [[nodiscard]] std::size_t at(std::uint32_t u, std::uint32_t v) const {
    return static_cast<std::size_t>(v) * width_ + u;
  }

  std::uint32_t width_;
  std::uint32_t height_;
  std::vector<Vec3f> centres_C_;  // apart, since most pixels need no more
  std::vector<float> angles_;     // 0: the model does not reach there
  std::vector<Slope> slopes_;
};

}  // namespace relnav::hil
