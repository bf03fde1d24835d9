// A function of the flight core, wrong by one unit in the last place: the pixel column of every projection, as another
// compiler's fused operation could make it. (Once in a run is not enough: 1e-14 px vanish when the state is rounded.) It stands
// before CameraModel::project_any() by the linker's --wrap: the flight code itself stays as it is.
#include <cmath>
#include <limits>

#include "fsw/geometry/camera_model.hpp"

namespace relnav::test {

Status real(const CameraModel* self, const Vec3& p_C, Vec2& uv_px, Mat23& J_uv_p) asm("__real_" RELNAV_WRAPPED);
Status wrap(const CameraModel* self, const Vec3& p_C, Vec2& uv_px, Mat23& J_uv_p) asm("__wrap_" RELNAV_WRAPPED);

Status wrap(const CameraModel* self, const Vec3& p_C, Vec2& uv_px, Mat23& J_uv_p) {
  const Status status = real(self, p_C, uv_px, J_uv_p);
  if (status == Status::ok) uv_px(0) = std::nextafter(uv_px(0), std::numeric_limits<double>::infinity());
  return status;
}

}  // namespace relnav::test
