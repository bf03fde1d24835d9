#include "fsw/geometry/camera_model.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "fsw/math/elementary.hpp"

namespace relnav {
namespace {

constexpr double min_slope = 0.02;         // of the distortion, over the whole domain
constexpr double corner_margin = 1.25;     // how far the domain may reach beyond the image's farthest corner
constexpr double max_theta = 2.98;         // rad, 171 deg: beyond, the ray's direction is lost in rounding
constexpr double max_radius_ratio = 10.0;  // largest undistorted radius considered, in units of the distorted corner's
constexpr double tolerance = 1e-13;        // relative to the domain; Newton's next step would be its square
constexpr int max_iterations = 60;         // Newton needs about 5; the rest is for its bisection safeguard
constexpr int scan_steps = 1024;
constexpr int bisection_steps = 60;

// g(s) = s (1 + c1 s^2 + c2 s^4 + c3 s^6 + c4 s^8): the radial part of every model.
struct OddPolynomial {
  double c1 = 0.0;
  double c2 = 0.0;
  double c3 = 0.0;
  double c4 = 0.0;

  // g(s) / s
  [[nodiscard]] double ratio(double s2) const { return 1.0 + s2 * (c1 + s2 * (c2 + s2 * (c3 + s2 * c4))); }
  // g'(s)
  [[nodiscard]] double slope(double s2) const {
    return 1.0 + s2 * (3.0 * c1 + s2 * (5.0 * c2 + s2 * (7.0 * c3 + s2 * (9.0 * c4))));
  }
  [[nodiscard]] double value(double s) const { return s * ratio(s * s); }
};

// Of every model but none.
OddPolynomial radial_polynomial(const CameraIntrinsics& k) {
  const auto& c = k.coefficients;
  if (k.model == DistortionModel::equidistant) return {c[0], c[1], c[2], c[3]};
  return {c[0], c[1], 0.0, 0.0};
}

// |(p1, p2)|. The tangential part t of radial_tangential has |t| <= 3 |p| r^2 and a symmetric Jacobian of norm
// <= 6 |p| r.
double tangential_size(const CameraIntrinsics& k) {
  if (k.model != DistortionModel::radial_tangential) return 0.0;
  return std::sqrt(k.coefficients[2] * k.coefficients[2] + k.coefficients[3] * k.coefficients[3]);
}

// s in [0, limit] with g(s) = value, for 0 <= value <= g(limit) and slope >= min_slope on [0, limit].
// Newton, kept inside a shrinking bracket.
Status invert(const OddPolynomial& g, double value, double limit, double& s_out) {
  double low = 0.0;
  double high = limit;
  double s = value < limit ? value : limit;
  for (int i = 0; i < max_iterations; ++i) {
    const double excess = g.value(s) - value;
    const double step = excess / g.slope(s * s);
    double next = s - step;
    if (std::fabs(step) <= tolerance * limit) {
      s_out = next < limit ? next : limit;
      return Status::ok;
    }
    if (excess > 0.0) {
      high = s;
    } else {
      low = s;
    }
    if (!(next > low && next < high)) next = 0.5 * (low + high);
    s = next;
  }
  return Status::no_convergence;
}

Mat2 symmetric_inverse(const Mat2& M) {
  const double scale = 1.0 / (M(0, 0) * M(1, 1) - M(0, 1) * M(0, 1));
  Mat2 inverse;
  inverse << scale * M(1, 1), -scale * M(0, 1),  //
      -scale * M(0, 1), scale * M(0, 0);
  return inverse;
}

// Jacobian of v -> v g(|v|) / |v|: slope g' along e = v / |v|, ratio g / |v| across it.
Mat2 radial_jacobian(double ratio, double slope, const Vec2& e) {
  return ratio * Mat2::Identity() + (slope - ratio) * e * e.transpose();
}

Vec2 direction(const Vec2& v, double length) { return length > 1e-150 ? Vec2(v / length) : Vec2(Vec2::Zero()); }

// radial_tangential, n to d, and its Jacobian, which is symmetric. In the domain it is also positive definite, hence
// the distortion is the gradient of a strictly convex function on a disc: one to one.
void distort_radial_tangential(const CameraIntrinsics& k, const Vec2& n, Vec2& d, Mat2& J_d_n) {
  const double p1 = k.coefficients[2];
  const double p2 = k.coefficients[3];
  const OddPolynomial g = radial_polynomial(k);
  const double x = n.x();
  const double y = n.y();
  const double r2 = x * x + y * y;
  const double ratio = g.ratio(r2);
  const double ratio_slope = 2.0 * (g.c1 + 2.0 * g.c2 * r2);  // d ratio / d r, over r
  d.x() = x * ratio + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x);
  d.y() = y * ratio + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y;
  const double mixed = ratio_slope * x * y + 2.0 * (p1 * x + p2 * y);
  J_d_n << ratio + ratio_slope * x * x + 2.0 * p1 * y + 6.0 * p2 * x, mixed,  //
      mixed, ratio + ratio_slope * y * y + 6.0 * p1 * y + 2.0 * p2 * x;
}

// radial_tangential, d to n: Newton in two dimensions from the solution without the tangential part.
Status undistort_radial_tangential(const CameraIntrinsics& k, double limit, double range, const Vec2& d, Vec2& n,
                                   Mat2& J_d_n) {
  const double tangential = tangential_size(k);
  const double r_d = d.norm();
  if (!(r_d <= range + 3.0 * tangential * limit * limit)) return Status::outside_domain;
  double r = 0.0;
  const Status started = invert(radial_polynomial(k), r_d < range ? r_d : range, limit, r);
  if (started != Status::ok) return started;
  Vec2 iterate = r * direction(d, r_d);
  bool at_limit = false;
  for (int i = 0; i < max_iterations; ++i) {
    Vec2 distorted;
    distort_radial_tangential(k, iterate, distorted, J_d_n);
    const Vec2 step = symmetric_inverse(J_d_n) * (distorted - d);
    iterate -= step;
    const double radius = iterate.norm();
    at_limit = radius > limit;
    if (at_limit) {
      iterate *= limit / radius;
    } else if (step.norm() <= tolerance * limit) {
      n = iterate;
      return Status::ok;
    }
  }
  return at_limit ? Status::outside_domain : Status::no_convergence;
}

}  // namespace

Expected<CameraModel> CameraModel::create(const CameraIntrinsics& k) {
  bool finite = std::isfinite(k.fu) && std::isfinite(k.fv) && std::isfinite(k.cu) && std::isfinite(k.cv);
  for (const double c : k.coefficients) finite = finite && std::isfinite(c);
  constexpr std::int32_t max_size_px = 65536;
  const bool sized = k.width_px >= 1 && k.height_px >= 1 && k.width_px <= max_size_px && k.height_px <= max_size_px;
  const bool known = k.model <= DistortionModel::equidistant;
  if (!finite || !sized || !known || !(k.fu > 0.0) || !(k.fv > 0.0)) return Status::invalid_argument;

  CameraModel camera;
  camera.intrinsics_ = k;
  if (k.model == DistortionModel::none) {
    camera.domain_limit_ = std::numeric_limits<double>::infinity();
    camera.range_limit_ = camera.domain_limit_;
    camera.covers_image_ = true;
    return camera;
  }

  // Distorted radius of the farthest corner of the image.
  const double left = -0.5 - k.cu;
  const double right = left + k.width_px;
  const double top = -0.5 - k.cv;
  const double bottom = top + k.height_px;
  const double reach_x = std::max(std::fabs(left), std::fabs(right)) / k.fu;
  const double reach_y = std::max(std::fabs(top), std::fabs(bottom)) / k.fv;
  const double corner = std::sqrt(reach_x * reach_x + reach_y * reach_y);

  const OddPolynomial g = radial_polynomial(k);
  const double tangential = tangential_size(k);
  // Distorted radius that a disc of radius s is sure to reach in every direction.
  const auto reached = [&](double s) {
    if (k.model == DistortionModel::radial_inverse) return s;
    return g.value(s) - 3.0 * tangential * s * s;
  };
  const auto inside = [&](double s) {
    return g.slope(s * s) - 6.0 * tangential * s >= min_slope && reached(s) <= corner_margin * corner;
  };

  double last = max_radius_ratio * corner;
  if (k.model == DistortionModel::radial_inverse) last = corner_margin * corner;
  if (k.model == DistortionModel::equidistant && !(last < max_theta)) last = max_theta;
  double low = 0.0;
  double high = last;
  bool bounded = false;
  for (int i = 1; i <= scan_steps && !bounded; ++i) {
    const double s = last * i / scan_steps;
    if (inside(s)) {
      low = s;
    } else {
      high = s;
      bounded = true;
    }
  }
  for (int i = 0; i < bisection_steps && bounded; ++i) {
    const double middle = 0.5 * (low + high);
    if (inside(middle)) {
      low = middle;
    } else {
      high = middle;
    }
  }
  camera.domain_limit_ = low;
  camera.range_limit_ = g.value(low);
  camera.covers_image_ = reached(low) >= corner;
  return camera;
}

Status CameraModel::project(const Vec3& p_C, Vec2& uv_px) const {
  Mat23 J_uv_p;
  return project(p_C, uv_px, J_uv_p);
}

Status CameraModel::project_any(const Vec3& p_C, Vec2& uv_px, Mat23& J_uv_p) const {
  if (!(intrinsics_.fu > 0.0)) return Status::not_configured;
  const double x = p_C.x();
  const double y = p_C.y();
  const double z = p_C.z();
  if (!(std::isfinite(x) && std::isfinite(y) && std::isfinite(z))) return Status::not_finite;
  const CameraIntrinsics& k = intrinsics_;
  constexpr double min_length = 1e-100;
  Vec2 d = Vec2::Zero();
  Mat23 J_d_p = Mat23::Zero();
  if (k.model == DistortionModel::equidistant) {
    // Scaled to a largest component of 1, so that nothing overflows.
    const double size = std::max(std::max(std::fabs(x), std::fabs(y)), std::fabs(z));
    if (!(size > min_length)) return Status::behind_camera;
    const Vec2 a(x / size, y / size);
    const double h = z / size;
    const double r = a.norm();
    const double theta = math::atan2(r, h);
    if (!(theta <= domain_limit_)) return h > 0.0 ? Status::outside_domain : Status::behind_camera;
    const OddPolynomial g = radial_polynomial(k);
    const double slope = g.slope(theta * theta);
    const double length2 = r * r + h * h;
    // r_d / r; beside the axis h = 1 (scaled, and the domain ends before 180 deg), where it tends to 1.
    const double ratio = r > 1e-9 ? g.value(theta) / r : 1.0;
    d = ratio * a;
    J_d_p.leftCols<2>() = radial_jacobian(ratio, slope * h / length2, direction(a, r)) / size;
    J_d_p.col(2) = (-slope / (length2 * size)) * a;
  } else {
    if (!(z > min_length) || !(z > 1e-6 * std::max(std::fabs(x), std::fabs(y)))) return Status::behind_camera;
    const Vec2 n(x / z, y / z);
    Mat2 J_d_n = Mat2::Identity();
    d = n;
    if (k.model == DistortionModel::radial_tangential) {
      if (!(n.norm() <= domain_limit_)) return Status::outside_domain;
      distort_radial_tangential(k, n, d, J_d_n);
    } else if (k.model == DistortionModel::radial_inverse) {
      const double r = n.norm();
      if (!(r <= range_limit_)) return Status::outside_domain;
      const OddPolynomial g = radial_polynomial(k);
      double r_d = 0.0;
      const Status inverted = invert(g, r, domain_limit_, r_d);
      if (inverted != Status::ok) return inverted;
      const double ratio = 1.0 / g.ratio(r_d * r_d);
      d = ratio * n;
      J_d_n = radial_jacobian(ratio, 1.0 / g.slope(r_d * r_d), direction(n, r));
    }
    Mat23 J_n_p;
    J_n_p << 1.0 / z, 0.0, -n.x() / z,  //
        0.0, 1.0 / z, -n.y() / z;
    J_d_p = J_d_n * J_n_p;
  }

  uv_px = Vec2(k.fu * d.x() + k.cu, k.fv * d.y() + k.cv);
  J_uv_p.row(0) = k.fu * J_d_p.row(0);
  J_uv_p.row(1) = k.fv * J_d_p.row(1);
  return Status::ok;
}

Status CameraModel::unproject(const Vec2& uv_px, Vec3& ray_C) const {
  Mat<3, 2> J_ray_uv;
  return unproject(uv_px, ray_C, J_ray_uv);
}

Status CameraModel::unproject(const Vec2& uv_px, Vec3& ray_C, Mat<3, 2>& J_ray_uv) const {
  const CameraIntrinsics& k = intrinsics_;
  if (!(k.fu > 0.0)) return Status::not_configured;
  const Vec2 d((uv_px.x() - k.cu) / k.fu, (uv_px.y() - k.cv) / k.fv);
  if (!(std::isfinite(d.x()) && std::isfinite(d.y()))) return Status::not_finite;
  Vec3 ray = Vec3::UnitZ();
  Mat<3, 2> J_ray_d = Mat<3, 2>::Zero();

  if (k.model == DistortionModel::none) {
    ray = Vec3(d.x(), d.y(), 1.0);
    J_ray_d.topRows<2>() = Mat2::Identity();
  } else if (k.model == DistortionModel::radial_tangential) {
    Vec2 n;
    Mat2 J_d_n;
    const Status inverted = undistort_radial_tangential(k, domain_limit_, range_limit_, d, n, J_d_n);
    if (inverted != Status::ok) return inverted;
    ray = Vec3(n.x(), n.y(), 1.0);
    J_ray_d.topRows<2>() = symmetric_inverse(J_d_n);
  } else if (k.model == DistortionModel::radial_inverse) {
    const double r_d = d.norm();
    if (!(r_d <= domain_limit_)) return Status::outside_domain;
    const OddPolynomial g = radial_polynomial(k);
    const double ratio = g.ratio(r_d * r_d);
    ray = Vec3(ratio * d.x(), ratio * d.y(), 1.0);
    J_ray_d.topRows<2>() = radial_jacobian(ratio, g.slope(r_d * r_d), direction(d, r_d));
  } else {  // equidistant
    const double r_d = d.norm();
    if (!(r_d <= range_limit_)) return Status::outside_domain;
    const OddPolynomial g = radial_polynomial(k);
    double theta = 0.0;
    const Status inverted = invert(g, r_d, domain_limit_, theta);
    if (inverted != Status::ok) return inverted;
    const math::SinCos of_theta = math::sincos(theta);
    const double slope = g.slope(theta * theta);
    const Vec2 e = direction(d, r_d);
    const double ratio = r_d > 1e-9 ? of_theta.sin / r_d : 1.0;
    ray = Vec3(ratio * d.x(), ratio * d.y(), of_theta.cos);
    J_ray_d.topRows<2>() = radial_jacobian(ratio, of_theta.cos / slope, e);
    J_ray_d.row(2) = (-of_theta.sin / slope) * e.transpose();
  }

  ray_C = ray;
  J_ray_uv.col(0) = J_ray_d.col(0) / k.fu;
  J_ray_uv.col(1) = J_ray_d.col(1) / k.fv;
  return Status::ok;
}

bool CameraModel::in_image(const Vec2& uv_px, double border_px) const {
  const double u = uv_px.x();
  const double v = uv_px.y();
  return u >= border_px - 0.5 && u <= intrinsics_.width_px - 0.5 - border_px && v >= border_px - 0.5 &&
         v <= intrinsics_.height_px - 0.5 - border_px;
}

}  // namespace relnav
