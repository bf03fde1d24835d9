#pragma once
#include <cmath>

#include "fsw/math/types.hpp"

namespace relnav::hil {

/// Three floats, for what is done a million times a frame. 32 bits tell directions apart to 1e-4 px.
/// Not set by itself: zeros in a million hits cost as much as a tenth of their rays.
struct Vec3f {
  float x;
  float y;
  float z;

  friend Vec3f operator+(Vec3f a, Vec3f b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  friend Vec3f operator-(Vec3f a, Vec3f b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  friend Vec3f operator-(Vec3f a) { return {-a.x, -a.y, -a.z}; }
  friend Vec3f operator*(float s, Vec3f a) { return {s * a.x, s * a.y, s * a.z}; }
};

inline float dot(Vec3f a, Vec3f b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vec3f cross(Vec3f a, Vec3f b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }
inline float norm(Vec3f a) { return std::sqrt(dot(a, a)); }
/// Zero stays zero.
inline Vec3f normalized(Vec3f a) {
  const float n = dot(a, a);
  return n > 0.0F ? (1.0F / std::sqrt(n)) * a : a;
}
inline Vec3f to_float(const Vec3& a) {
  return {static_cast<float>(a.x()), static_cast<float>(a.y()), static_cast<float>(a.z())};
}
inline Vec3 to_double(Vec3f a) {
  return Vec3(static_cast<double>(a.x), static_cast<double>(a.y), static_cast<double>(a.z));
}
/// Two unit vectors that make a right-handed base with unit vector n (Duff et al., JCGT 6(1), 2017).
inline void base_around(Vec3f n, Vec3f& s, Vec3f& t) {
  const float sign = std::copysign(1.0F, n.z);
  const float a = -1.0F / (sign + n.z);
  const float b = n.x * n.y * a;
  s = {1.0F + sign * n.x * n.x * a, sign * b, -sign * n.x};
  t = {b, sign + n.y * n.y * a, -n.y};
}

/// A rotation's rows.
struct Mat3f {
  Vec3f rows[3];
  friend Vec3f operator*(const Mat3f& a, Vec3f v) { return {dot(a.rows[0], v), dot(a.rows[1], v), dot(a.rows[2], v)}; }
};
inline Mat3f to_float(const Mat3& a) {
  return {{to_float(Vec3(a.row(0))), to_float(Vec3(a.row(1))), to_float(Vec3(a.row(2)))}};
}

}  // namespace relnav::hil
