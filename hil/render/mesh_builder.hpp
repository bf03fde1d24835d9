#pragma once
#include <cstdint>
#include <vector>

#include "hil/render/mesh.hpp"

namespace relnav::hil {

/// Solids of which a satellite is put together. Texture coordinates are metres on the surface.
class MeshBuilder {
 public:
  [[nodiscard]] std::uint32_t add_material(const Material& material);

  /// Corners in order, seen from outside counter-clockwise; flat, convex.
  void add_polygon(const std::vector<Vec3f>& corners_T, std::uint32_t material);
  /// Edges along the columns of R_TP.
  void add_box(const Vec3& centre_T, const Vec3& size, std::uint32_t material, const Mat3& R_TP = Mat3::Identity());

  /// A point of a turned profile: radius, and place along the axis.
  struct Turn {
    double radius;
    double along;
  };
  /// Profile turned about the axis through `base_T` (unit vector); each of its pieces is smooth around, with an edge to the
  /// next. Along the profile, the outside lies to its right when the axis points up.
  void add_turned(const Vec3& base_T, const Vec3& axis_T, const std::vector<Turn>& profile, std::uint32_t material,
                  int sides = 24);
  /// A rod with flat ends.
  void add_rod(const Vec3& from_T, const Vec3& to_T, double radius, std::uint32_t material, int sides = 12);

  [[nodiscard]] Mesh& mesh() { return mesh_; }

 private:
  Mesh mesh_;
};

}  // namespace relnav::hil
