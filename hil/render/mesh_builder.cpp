#include "hil/render/mesh_builder.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace relnav::hil {

std::uint32_t MeshBuilder::add_material(const Material& material) {
  mesh_.materials.push_back(material);
  return static_cast<std::uint32_t>(mesh_.materials.size() - 1);
}

void MeshBuilder::add_polygon(const std::vector<Vec3f>& corners_T, std::uint32_t material) {
  const Vec3f normal_T = normalized(cross(corners_T.at(1) - corners_T.at(0), corners_T.at(2) - corners_T.at(0)));
  const Vec3f u_T = normalized(corners_T[1] - corners_T[0]);
  const Vec3f v_T = cross(normal_T, u_T);
  const auto first = static_cast<std::uint32_t>(mesh_.vertices.size());
  // Neighbours must not show the same piece of a pattern; plates of labels begin at a plate's corner.
  const bool is_label = mesh_.materials.at(material).pattern == Pattern::labels;
  const float shift = (is_label ? 0.15F : 0.137F) * static_cast<float>(first % 97U);
  for (const Vec3f& p_T : corners_T) {
    mesh_.vertices.push_back(
        {p_T, normal_T, dot(p_T - corners_T[0], u_T) + shift, dot(p_T - corners_T[0], v_T) + shift});
  }
  for (std::uint32_t i = 2; i < corners_T.size(); ++i) {
    mesh_.triangles.push_back({{first, first + i - 1, first + i}, material});
  }
}

void MeshBuilder::add_box(const Vec3& centre_T, const Vec3& size, std::uint32_t material, const Mat3& R_TP) {
  const auto corner = [&](int axis, double along, double a, double b) {
    Vec3 p = Vec3::Zero();
    p(axis) = 0.5 * along * size(axis);
    p((axis + 1) % 3) = 0.5 * a * size((axis + 1) % 3);
    p((axis + 2) % 3) = 0.5 * b * size((axis + 2) % 3);
    return to_float(Vec3(centre_T + R_TP * p));
  };
  for (int axis = 0; axis < 3; ++axis) {
    add_polygon({corner(axis, 1, -1, -1), corner(axis, 1, 1, -1), corner(axis, 1, 1, 1), corner(axis, 1, -1, 1)},
                material);
    add_polygon({corner(axis, -1, -1, -1), corner(axis, -1, -1, 1), corner(axis, -1, 1, 1), corner(axis, -1, 1, -1)},
                material);
  }
}

void MeshBuilder::add_turned(const Vec3& base_T, const Vec3& axis_T, const std::vector<Turn>& profile,
                             std::uint32_t material, int sides) {
  const Vec3f axis = to_float(axis_T);
  Vec3f s;
  Vec3f t;
  base_around(axis, s, t);
  double length = 0.0;
  for (std::size_t k = 1; k < profile.size(); ++k) {
    const Turn a = profile[k - 1];
    const Turn b = profile[k];
    const double piece = std::hypot(b.radius - a.radius, b.along - a.along);
    if (piece <= 0.0) continue;
    const auto out = static_cast<float>((b.along - a.along) / piece);
    const auto up = static_cast<float>(-(b.radius - a.radius) / piece);
    const auto first = static_cast<std::uint32_t>(mesh_.vertices.size());
    for (int i = 0; i <= sides; ++i) {
      const double angle = 2.0 * std::numbers::pi * i / sides;
      const Vec3f radial = static_cast<float>(std::cos(angle)) * s + static_cast<float>(std::sin(angle)) * t;
      const Vec3f normal_T = out * radial + up * axis;
      const auto around = static_cast<float>(angle * std::max(a.radius, b.radius));
      for (const auto& [turn, along] : {std::pair(a, length), std::pair(b, length + piece)}) {
        mesh_.vertices.push_back(
            {to_float(base_T) + static_cast<float>(turn.radius) * radial + static_cast<float>(turn.along) * axis,
             normal_T, around, static_cast<float>(along)});
      }
    }
    for (std::uint32_t i = 0; i < static_cast<std::uint32_t>(sides); ++i) {
      const std::uint32_t p = first + 2 * i;
      if (a.radius > 0.0) mesh_.triangles.push_back({{p, p + 2, p + 1}, material});
      if (b.radius > 0.0) mesh_.triangles.push_back({{p + 1, p + 2, p + 3}, material});
    }
    length += piece;
  }
}

void MeshBuilder::add_rod(const Vec3& from_T, const Vec3& to_T, double radius, std::uint32_t material, int sides) {
  const double length = (to_T - from_T).norm();
  if (length <= 0.0) return;
  add_turned(from_T, (to_T - from_T) / length, {{0.0, 0.0}, {radius, 0.0}, {radius, length}, {0.0, length}}, material,
             sides);
}

}  // namespace relnav::hil
