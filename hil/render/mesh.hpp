#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "hil/render/material.hpp"
#include "hil/render/vec3f.hpp"

namespace relnav::hil {

struct Triangle {
  std::array<std::uint32_t, 3> corners{};  ///< positions in Mesh::vertices
  std::uint32_t material = 0;              ///< position in Mesh::materials
};

struct Vertex {
  Vec3f p_T{};       ///< m
  Vec3f normal_T{};  ///< unit length
  float u = 0.0F;    ///< texture; in metres for every pattern but `image`
  float v = 0.0F;
};

/// Triangles in the target's body frame T.
struct Mesh {
  std::vector<Vertex> vertices;
  std::vector<Triangle> triangles;
  std::vector<Material> materials;
};

struct Bounds {
  Vec3f low_T;
  Vec3f high_T;
};
/// Of a mesh that is not empty.
[[nodiscard]] Bounds bounds_of(const Mesh& mesh);

}  // namespace relnav::hil
