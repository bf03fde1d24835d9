#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "hil/render/mesh.hpp"
#include "hil/render/texture.hpp"

namespace relnav::hil {

struct Ball {
  Vec3f centre_T;
  float radius = 0.0F;
};

/// Rays of neighbouring pixels, traced together.
struct alignas(32) RayPacket {
  static constexpr std::size_t size = 8;
  std::array<float, size> origin_x, origin_y, origin_z;
  std::array<float, size> toward_x, toward_y, toward_z;
  std::array<float, size> longest;
  std::array<std::int32_t, size> is_used;  ///< 0 or -1

  void set(std::size_t i, Vec3f origin_T, Vec3f toward_T, float t) {
    origin_x[i] = origin_T.x;
    origin_y[i] = origin_T.y;
    origin_z[i] = origin_T.z;
    toward_x[i] = toward_T.x;
    toward_y[i] = toward_T.y;
    toward_z[i] = toward_T.z;
    longest[i] = t;
    is_used[i] = -1;
  }
};

/// What a ray meets first.
struct Surface {
  static constexpr std::uint32_t none = 0xFFFFFFFFU;
  static constexpr std::uint32_t ball = 0xFFFFFFFEU;
  std::uint32_t material = none;  ///< position in Mesh::materials, or one of the above
  float depth = 0.0F;             ///< in lengths of the ray's direction
  Vec3f p_T;
  Vec3f face_T;     ///< unit normal of the triangle, toward the viewer
  Vec3f normal_T;   ///< smoothed, on the side of face_T
  Vec3f along_u_T;  ///< unit vector along the texture's u
  float u = 0.0F;
  float v = 0.0F;
  float per_metre = 1.0F;  ///< texture coordinates a metre
};

/// Mesh and luminous balls, ready for rays (Embree). Throws InputError when a material's image cannot be read,
/// std::runtime_error when Embree fails.
class MeshScene {
 public:
  MeshScene(Mesh mesh, const std::vector<Ball>& balls);
  ~MeshScene();
  MeshScene(const MeshScene&) = delete;
  MeshScene& operator=(const MeshScene&) = delete;

  /// Unused rays meet nothing.
  void trace(const RayPacket& rays, std::array<Surface, RayPacket::size>& met) const;
  /// Bit i: something is in the way of ray i between 0 and its `longest`.
  [[nodiscard]] std::uint32_t blocked(const RayPacket& rays, bool is_coherent) const;

  [[nodiscard]] const Mesh& mesh() const { return mesh_; }
  /// Null: the material is plain.
  [[nodiscard]] const Texture* texture(std::uint32_t material) const { return textures_[material].get(); }
  [[nodiscard]] Ball bounds() const { return bounds_; }  ///< around all

 private:
  struct Embree;
  std::unique_ptr<Embree> embree_;
  Mesh mesh_;
  std::vector<std::shared_ptr<const Texture>> textures_;
  std::vector<Vec3f> along_u_T_;  // of each triangle
  std::vector<float> per_metre_;
  Ball bounds_;
};

}  // namespace relnav::hil
