// A double of the flight core, wrong by one unit in its last place, once: the pixel that CameraModel::project_any() gives at
// its first call. Stands before it by the linker's --wrap, so that the flight code itself stays as it is.
#include <cmath>
#include <limits>

#include "fsw/geometry/camera_model.hpp"

namespace relnav::test {

Status real(const CameraModel* self, const Vec3& p_C, Vec2& uv_px, Mat23& J_uv_p) asm("__real_" RELNAV_WRAPPED);
Status wrap(const CameraModel* self, const Vec3& p_C, Vec2& uv_px, Mat23& J_uv_p) asm("__wrap_" RELNAV_WRAPPED);

static bool disturbed = false;

Status wrap(const CameraModel* self, const Vec3& p_C, Vec2& uv_px, Mat23& J_uv_p) {
  const Status status = real(self, p_C, uv_px, J_uv_p);
  if (status == Status::ok && !disturbed) {
    disturbed = true;
    uv_px(0) = std::nextafter(uv_px(0), std::numeric_limits<double>::infinity());
  }
  return status;
}

}  // namespace relnav::test
