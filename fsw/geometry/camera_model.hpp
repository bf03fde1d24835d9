#pragma once
#include <array>
#include <cmath>
#include <cstdint>

#include "fsw/base/expected.hpp"
#include "fsw/base/status.hpp"
#include "fsw/math/types.hpp"

namespace relnav {

/// Distortion: how the normalised image point n = (x, y) / z of a point in C (or its angle off the axis) becomes the
/// distorted point d, with uv_px = (fu d_x + cu, fv d_y + cv). r = |n|, r_d = |d|.
enum class DistortionModel : std::uint8_t {
  none,               ///< d = n; coefficients unused
  radial_tangential,  ///< k1 k2 p1 p2 of OpenCV (Brown 1966): d_x = x f + 2 p1 x y + p2 (r^2 + 2 x^2),
                      ///< d_y = y f + p1 (r^2 + 2 y^2) + 2 p2 x y, f = 1 + k1 r^2 + k2 r^4
  radial_inverse,     ///< k1 k2: n = d (1 + k1 r_d^2 + k2 r_d^4); noncooperative.md, (20)-(22)
  equidistant,        ///< k1 k2 k3 k4 of OpenCV's fisheye (Kannala, Brandt, PAMI 28(8), 2006, odd polynomial):
  ///< r_d = theta (1 + k1 theta^2 + k2 theta^4 + k3 theta^6 + k4 theta^8), theta = angle off the axis
};

struct CameraIntrinsics {
  double fu = 0.0;  ///< focal lengths, pixels
  double fv = 0.0;
  double cu = 0.0;  ///< principal point, pixels; (0, 0) is the centre of the top-left pixel
  double cv = 0.0;
  std::int32_t width_px = 0;
  std::int32_t height_px = 0;
  DistortionModel model = DistortionModel::none;
  std::array<double, 4> coefficients{};  ///< in the order named at the model
};

/// Camera without skew: points in C to pixels and back. Immutable; every call is bounded in time.
///
/// Domain: create() finds the largest radius up to which the distortion is safely invertible (its slope stays above 2 %
/// in every direction, which makes it one to one), but no more than the image's farthest corner needs plus 25 %, since
/// a calibration says nothing beyond. `none` has no such limit; equidistant may reach beyond 90 deg, up to 171 deg off
/// the axis. A calibration that turns back before the image's corners is accepted; covers_image() tells, and pixels
/// beyond give Status::outside_domain.
class CameraModel {
 public:
  /// No camera yet: project() and unproject() give Status::not_configured.
  CameraModel() = default;

  /// invalid_argument: non-finite value, non-positive focal length, size outside 1 .. 65536, unknown model.
  [[nodiscard]] static Expected<CameraModel> create(const CameraIntrinsics& intrinsics);

  [[nodiscard]] const CameraIntrinsics& intrinsics() const { return intrinsics_; }

  /// p_C in any unit of length (only its direction matters). The pixel may lie outside the image: see in_image().
  /// not_configured; not_finite; behind_camera: z <= 1e-6 max(|x|, |y|) or z <= 1e-100 (equidistant: z <= 0 and outside
  /// the domain, or |p_C| <= 1e-100); outside_domain; no_convergence. On an error the outputs are untouched.
  Status project(const Vec3& p_C, Vec2& uv_px) const;
  /// Also J_uv_p = d uv_px / d p_C, pixels per unit of p_C.
  Status project(const Vec3& p_C, Vec2& uv_px, Mat23& J_uv_p) const {
    const double x = p_C.x();
    const double y = p_C.y();
    const double z = p_C.z();
    // Most poses are of such points, many times over: in line.
    const bool is_plain = intrinsics_.model == DistortionModel::none && intrinsics_.fu > 0.0;
    const bool is_ahead = z > 1e-100 && z < 1e100 && z > 1e-6 * std::fabs(x) && z > 1e-6 * std::fabs(y);
    if (!is_plain || !is_ahead) return project_any(p_C, uv_px, J_uv_p);
    const double inverse = 1.0 / z;
    const double u = intrinsics_.fu * (x * inverse);
    const double v = intrinsics_.fv * (y * inverse);
    uv_px = Vec2(u + intrinsics_.cu, v + intrinsics_.cv);
    J_uv_p << intrinsics_.fu * inverse, 0.0, -u * inverse,  //
        0.0, intrinsics_.fv * inverse, -v * inverse;
    return Status::ok;
  }

  /// Viewing ray of a pixel in C: with z = 1, except equidistant: of unit length, as it may lie beyond 90 deg.
  /// not_configured; not_finite; outside_domain; no_convergence. On an error the outputs are untouched.
  Status unproject(const Vec2& uv_px, Vec3& ray_C) const;
  /// Also J_ray_uv = d ray_C / d uv_px.
  Status unproject(const Vec2& uv_px, Vec3& ray_C, Mat<3, 2>& J_ray_uv) const;

  /// Inside the image (whose pixels reach half a pixel beyond their centres), at least border_px from its edge.
  [[nodiscard]] bool in_image(const Vec2& uv_px, double border_px = 0.0) const;

  /// Every pixel of the image can be unprojected.
  [[nodiscard]] bool covers_image() const { return covers_image_; }

  /// Limit of the domain: r (radial_tangential), r_d (radial_inverse), theta in rad (equidistant), infinity (none).
  [[nodiscard]] double domain_limit() const { return domain_limit_; }

 private:
  Status project_any(const Vec3& p_C, Vec2& uv_px, Mat23& J_uv_p) const;

  CameraIntrinsics intrinsics_;
  double domain_limit_ = 0.0;
  double range_limit_ = 0.0;  // value of the radial polynomial at domain_limit_
  bool covers_image_ = false;
};

}  // namespace relnav
