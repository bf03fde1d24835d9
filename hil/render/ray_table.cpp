#include "hil/render/ray_table.hpp"

#include <cmath>
#include <stdexcept>

namespace relnav::hil {

RayTable::RayTable(const CameraModel& camera)
    : width_(static_cast<std::uint32_t>(camera.intrinsics().width_px)),
      height_(static_cast<std::uint32_t>(camera.intrinsics().height_px)) {
  if (width_ == 0 || height_ == 0) throw std::invalid_argument("the renderer needs a camera");
  const std::size_t pixels = static_cast<std::size_t>(width_) * height_;
  centres_C_.resize(pixels);
  angles_.resize(pixels);
  slopes_.resize(pixels);
  for (std::uint32_t v = 0; v < height_; ++v) {
    for (std::uint32_t u = 0; u < width_; ++u) {
      Vec3 ray_C;
      Mat<3, 2> J_ray_uv;
      if (camera.unproject(Vec2(u, v), ray_C, J_ray_uv) != Status::ok) continue;
      // The derivative of the unit vector: what of it is across the ray.
      const double length = ray_C.norm();
      const Vec3 unit_C = ray_C / length;
      const Mat<3, 2> J_unit = (J_ray_uv - unit_C * (unit_C.transpose() * J_ray_uv)) / length;
      Slope& slope = slopes_[at(u, v)];
      slope.along_u_C = to_float(Vec3(J_unit.col(0)));
      slope.along_v_C = to_float(Vec3(J_unit.col(1)));
      centres_C_[at(u, v)] = to_float(unit_C);
      angles_[at(u, v)] = std::sqrt(norm(cross(slope.along_u_C, slope.along_v_C)));
    }
  }
}

}  // namespace relnav::hil
