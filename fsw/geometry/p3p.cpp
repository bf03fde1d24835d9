#include "fsw/geometry/p3p.hpp"

#include <algorithm>
#include <cmath>

#include "fsw/attitude/so3.hpp"

namespace relnav {
namespace {

constexpr double least_sine = 1e-3;
constexpr int cubic_steps = 20;
constexpr int polish_steps = 4;
constexpr double most_misfit = 1e-9;  // of squared distances, over their sum; solutions come within some 1e-15

/// Real roots of x^2 + b x + c, without cancellation. False: none.
bool quadratic_roots(double b, double c, double& r1, double& r2) {
  const double v = b * b - 4.0 * c;
  if (!(v >= 0.0)) return false;
  const double y = std::sqrt(v);
  const double q = b < 0.0 ? 0.5 * (-b + y) : 0.5 * (-b - y);
  r1 = q;
  r2 = std::abs(q) > 0.0 ? c / q : 0.0;
  return true;
}

/// One real root of x^3 + b x^2 + c x + d, an outer one, where Newton's method is monotone.
double cubic_root(double b, double c, double d) {
  double x = -b / 3.0;
  const double v2 = b * b - 3.0 * c;
  if (v2 > 0.0) {
    const double v = std::sqrt(v2);
    const double low = (-b - v) / 3.0;
    const double at_low = ((low + b) * low + c) * low + d;
    if (at_low > 0.0) {
      x = low - std::sqrt(at_low / v);
    } else {
      const double high = (-b + v) / 3.0;
      const double at_high = ((high + b) * high + c) * high + d;
      x = high + std::sqrt(std::max(0.0, -at_high / v));
    }
  } else if (!(std::abs((3.0 * x + 2.0 * b) * x + c) > 1e-4)) {
    x += 1.0;
  }
  for (int k = 0; k < cubic_steps; ++k) {
    const double f = ((x + b) * x + c) * x + d;
    const double slope = (3.0 * x + 2.0 * b) * x + c;
    if (!(std::abs(slope) > 0.0)) break;
    const double step = f / slope;
    x -= step;
    if (!(std::abs(step) > 1e-15 * std::abs(x))) break;
  }
  return x;
}

/// Symmetric, singular matrix.
struct Singular {
  double a00, a01, a02, a11, a12, a22;
};

/// Unit eigenvector of e.
Vec3 eigenvector(const Singular& A, double e) {
  const double scale = 1.0 / (e * (A.a00 + A.a11) - A.a00 * A.a11 - e * e + A.a01 * A.a01);
  const double x = -(e * A.a02 + A.a01 * A.a12 - A.a02 * A.a11) * scale;
  const double y = -(e * A.a12 + A.a01 * A.a02 - A.a00 * A.a12) * scale;
  const double norm = 1.0 / std::sqrt(x * x + y * y + 1.0);
  return {norm * x, norm * y, norm};
}

/// |l1 y1 - l2 y2|^2 - a12 and so on.
Vec3 misfits(const P3pPoints& q, double c12, double c13, double c23, const Vec3& l) {
  const double x = l(0), y = l(1), z = l(2);
  return {x * x + y * y - 2.0 * c12 * x * y - q.a12, x * x + z * z - 2.0 * c13 * x * z - q.a13,
          y * y + z * z - 2.0 * c23 * y * z - q.a23};
}

double total(const Vec3& r) { return std::abs(r(0)) + std::abs(r(1)) + std::abs(r(2)); }

/// Distances along the rays, towards no misfits. False: they do not come near, there is no such triangle.
bool polish(const P3pPoints& q, double c12, double c13, double c23, Vec3& l) {
  const double size = q.a12 + q.a13 + q.a23;
  for (int k = 0; k < polish_steps; ++k) {
    const Vec3 r = misfits(q, c12, c13, c23, l);
    if (total(r) < 1e-14 * size) return true;
    // Half Jacobian [[a b 0] [c 0 d] [0 e f]].
    const double x = l(0), y = l(1), z = l(2);
    const double a = x - c12 * y, b = y - c12 * x;
    const double c = x - c13 * z, d = z - c13 * x;
    const double e = y - c23 * z, f = z - c23 * y;
    const double det = -a * d * e - b * c * f;
    if (!(std::abs(det) > 0.0)) return false;
    const double s = -0.5 / det;
    l += s * Vec3(-d * e * r(0) - b * f * r(1) + b * d * r(2), -c * f * r(0) + a * f * r(1) - a * d * r(2),
                  c * e * r(0) - a * e * r(1) - b * c * r(2));
  }
  return total(misfits(q, c12, c13, c23, l)) < most_misfit * size;
}

}  // namespace

Status make_p3p_points(const std::array<Vec3, 3>& p_T, P3pPoints& out) {
  const Vec3 d12 = p_T[0] - p_T[1];
  const Vec3 d13 = p_T[0] - p_T[2];
  const Vec3 normal = cross_matrix(d12) * d13;
  const double n2 = normal.squaredNorm();
  if (!std::isfinite(n2)) return Status::not_finite;
  if (!(n2 > least_sine * least_sine * d12.squaredNorm() * d13.squaredNorm())) return Status::rank_deficient;
  out.p1_T = p_T[0];
  out.a12 = d12.squaredNorm();
  out.a13 = d13.squaredNorm();
  out.a23 = (p_T[1] - p_T[2]).squaredNorm();
  // Rows of the inverse of [u v w]: v x w, w x u, u x v over their determinant |w|^2.
  out.basis_inverse.row(0) = (cross_matrix(d13) * normal).transpose() / n2;
  out.basis_inverse.row(1) = (cross_matrix(normal) * d12).transpose() / n2;
  out.basis_inverse.row(2) = normal.transpose() / n2;
  return Status::ok;
}

int solve_p3p(const P3pPoints& q, const std::array<Vec3, 3>& rays_C, std::array<Pose, 4>& out) {
  const double c12 = rays_C[0].dot(rays_C[1]);
  const double c13 = rays_C[0].dot(rays_C[2]);
  const double c23 = rays_C[1].dot(rays_C[2]);
  const double b12 = -2.0 * c12, b13 = -2.0 * c13, b23 = -2.0 * c23;
  const double a12 = q.a12, a13 = q.a13, a23 = q.a23;
  const double s12 = 1.0 - c12 * c12, s13 = 1.0 - c13 * c13, s23 = 1.0 - c23 * c23;
  const double blob = c12 * c23 * c13 - 1.0;

  // D1 + g D2 is singular where this cubic vanishes.
  const double p3 = a13 * (a23 * s13 - a13 * s23);
  const double p2 = 2.0 * blob * a23 * a13 + a13 * (2.0 * a12 + a13) * s23 + a23 * (a23 - a12) * s13;
  const double p1 = a23 * (a13 - a23) * s12 - a12 * a12 * s23 - 2.0 * a12 * (blob * a23 + a13 * s23);
  const double p0 = a12 * (a12 * s23 - a23 * s12);
  double g;
  if (std::abs(p3) >= std::abs(p0)) {
    if (!(std::abs(p3) > 0.0)) return 0;
    g = cubic_root(p2 / p3, p1 / p3, p0 / p3);
  } else {
    // The other way round, for symmetric layouts where p3 vanishes.
    g = 1.0 / cubic_root(p1 / p0, p2 / p0, p3 / p0);
  }
  if (!std::isfinite(g)) return 0;
  const Singular A{
      a23 * (1.0 - g),      0.5 * a23 * b12, -0.5 * a23 * b13 * g, a23 - a12 + a13 * g, 0.5 * b23 * (a13 * g - a12),
      g * (a13 - a23) - a12};
  double e1, e2;
  const double product = A.a00 * (A.a11 + A.a22) + A.a11 * A.a22 - A.a01 * A.a01 - A.a02 * A.a02 - A.a12 * A.a12;
  if (!quadratic_roots(-A.a00 - A.a11 - A.a22, product, e1, e2)) return 0;
  if (std::abs(e1) < std::abs(e2)) std::swap(e1, e2);
  const Vec3 v1 = eigenvector(A, e1);
  const Vec3 v2 = eigenvector(A, e2);
  const double ratio = std::sqrt(std::max(0.0, -e2 / e1));

  int count = 0;
  for (int sign = 0; sign < 2; ++sign) {
    const double s = sign == 0 ? ratio : -ratio;
    const double w = 1.0 / (s * v2(0) - v1(0));
    const double w0 = (v1(1) - s * v2(1)) * w;
    const double w1 = (v1(2) - s * v2(2)) * w;
    const double a = 1.0 / ((a13 - a12) * w1 * w1 - a12 * b13 * w1 - a12);
    const double b = (a13 * b12 * w1 - a12 * b13 * w0 - 2.0 * w0 * w1 * (a12 - a13)) * a;
    const double c = ((a13 - a12) * w0 * w0 + a13 * b12 * w0 + a13) * a;
    std::array<double, 2> tau{};
    if (!quadratic_roots(b, c, tau[0], tau[1])) continue;
    for (const double t : tau) {
      if (!(t > 0.0)) continue;
      const double l2 = std::sqrt(a23 / (t * (b23 + t) + 1.0));
      Vec3 l(w0 * l2 + w1 * t * l2, l2, t * l2);
      if (!(l(0) >= 0.0) || !std::isfinite(l(0))) continue;
      const bool fits = polish(q, c12, c13, c23, l);
      if (!(l(0) > 0.0 && l(1) > 0.0 && l(2) > 0.0 && fits)) continue;
      const Vec3 first = l(0) * rays_C[0];
      Mat3 basis;
      basis.col(0) = first - l(1) * rays_C[1];
      basis.col(1) = first - l(2) * rays_C[2];
      basis.col(2) = cross_matrix(Vec3(basis.col(0))) * basis.col(1);
      Pose& pose = out[static_cast<std::size_t>(count++)];
      pose.R_CT.noalias() = basis * q.basis_inverse;
      pose.t_CT = first - pose.R_CT * q.p1_T;
    }
  }
  return count;
}

}  // namespace relnav
