#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "hil/render/lighting.hpp"
#include "hil/render/mesh.hpp"
#include "hil/render/texture.hpp"

namespace relnav::hil {

struct Ball {
  Vec3f centre_T{};
  float radius = 0.0F;
};

/// Rays of neighbouring pixels, traced together.
struct alignas(32) RayPacket {
  static constexpr std::size_t size = 8;
  std::array<float, size> origin_x, origin_y, origin_z;
  std::array<float, size> toward_x, toward_y, toward_z;
  std::array<float, size> longest;
  std::array<std::int32_t, size> is_used;  ///< 0 or -1

  RayPacket() {
    is_used.fill(0);
  }  // of unused rays nothing is read, and filling all of them takes longer than tracing some

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
struct Hit {
  static constexpr std::uint32_t nothing = 0x3FFFFFFFU;
  static constexpr std::uint32_t ball = 0x3FFFFFFEU;
  std::uint32_t material = nothing;  ///< position in Mesh::materials, or one of the above
  std::uint32_t triangle = 0;        ///< position in Mesh::triangles
  float depth = 0.0F;                ///< in lengths of the ray's direction
  float weight_b = 0.0F;             ///< of the triangle's second and third corner
  float weight_c = 0.0F;
  Vec3f p_T;
  Vec3f face_T;  ///< unit normal of the triangle, toward the viewer

  Hit() {}  // NOLINT(modernize-use-equals-default): nothing is set, as trace() sets what counts
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
  void trace(const RayPacket& rays, std::array<Hit, RayPacket::size>& met) const;
  /// Puts what light needs to know of a hit on a triangle into place `i`. `footprint`: of a pixel, m.
  void describe(const Hit& hit, Vec3f to_viewer_T, float lit, float footprint, Patches& patches, std::size_t i) const;
  /// Bit i: something is in the way of ray i between 0 and its `longest`.
  [[nodiscard]] std::uint32_t blocked(const RayPacket& rays, bool is_coherent) const;

  /// Nothing but mesh around the point, whichever way one looks.
  [[nodiscard]] bool encloses(Vec3f p_T) const;

  [[nodiscard]] const Mesh& mesh() const { return mesh_; }
  [[nodiscard]] Vec3f face_T(std::uint32_t triangle) const { return facets_[triangle].face_T; }
  /// Piece of surface without a crease: triangles that share corners.
  [[nodiscard]] std::uint32_t smooth_piece(std::uint32_t triangle) const { return pieces_[triangle]; }
  [[nodiscard]] Ball bounds() const { return bounds_; }  ///< around all
  /// Some thirty, which hold all between them.
  [[nodiscard]] const std::vector<Ball>& parts() const { return parts_; }

 private:
  struct Embree;
  std::unique_ptr<Embree> embree_;
  Mesh mesh_;
  std::vector<std::shared_ptr<const Texture>> textures_;
  struct Facet {
    Vec3f face_T;
    std::uint32_t material;
  };
  struct Laid {  // texture on a triangle
    Vec3f along_u_T;
    float per_metre;
  };
  std::vector<Facet> facets_;  // of each triangle: what every ray needs, apart
  std::vector<Laid> laid_;
  std::vector<std::uint32_t> pieces_;
  Ball bounds_;
  std::vector<Ball> parts_;
};

}  // namespace relnav::hil
