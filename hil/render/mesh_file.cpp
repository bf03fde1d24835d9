#include "hil/render/mesh_file.hpp"

#include <assimp/material.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <algorithm>
#include <assimp/Importer.hpp>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>

#include "platform/files/input_error.hpp"
#include "platform/files/text.hpp"

namespace relnav::hil {
namespace {

constexpr const char* expectation = "a mesh of triangles: glTF, OBJ, STL or what else Assimp reads";

/// Files hold colours as a screen wants them (sRGB, IEC 61966-2-1); OBJ and glTF factors are linear.
float grey_of(const aiColor4D& colour) { return 0.2126F * colour.r + 0.7152F * colour.g + 0.0722F * colour.b; }

bool holds(const std::string& name, std::initializer_list<const char*> words) {
  std::string lower = name;
  std::transform(lower.begin(), lower.end(), lower.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return std::any_of(words.begin(), words.end(), [&](const char* w) { return lower.find(w) != std::string::npos; });
}

Material material_of(const aiMaterial& source, const std::filesystem::path& folder) {
  Material material;
  material.name = source.GetName().C_Str();
  aiColor4D colour(0.5F, 0.5F, 0.5F, 1.0F);
  if (source.Get(AI_MATKEY_BASE_COLOR, colour) != aiReturn_SUCCESS) {
    static_cast<void>(source.Get(AI_MATKEY_COLOR_DIFFUSE, colour));
  }
  material.base = std::clamp(grey_of(colour), 0.0F, 1.0F);
  static_cast<void>(source.Get(AI_MATKEY_METALLIC_FACTOR, material.metallic));
  material.metallic = std::clamp(material.metallic, 0.0F, 1.0F);
  float shininess = 0.0F;
  if (source.Get(AI_MATKEY_ROUGHNESS_FACTOR, material.roughness) != aiReturn_SUCCESS &&
      source.Get(AI_MATKEY_SHININESS, shininess) == aiReturn_SUCCESS && shininess > 0.0F) {
    // Width of GGX for Phong's exponent: alpha^2 = 2 / (n + 2) (Walter et al., EGSR 2007, section 5.2 for Beckmann).
    material.roughness = std::sqrt(std::sqrt(2.0F / (shininess + 2.0F)));
  }
  material.roughness = std::clamp(material.roughness, 0.05F, 1.0F);
  aiColor4D emission(0.0F, 0.0F, 0.0F, 1.0F);
  if (source.Get(AI_MATKEY_COLOR_EMISSIVE, emission) == aiReturn_SUCCESS) {
    material.emission = std::max(0.0F, grey_of(emission));
  }
  if (holds(material.name, {"foil", "mli", "blanket"})) material.pattern = Pattern::foil;
  if (holds(material.name, {"cell", "solar"})) material.pattern = Pattern::solar_cells;
  aiString texture;
  if (source.GetTexture(aiTextureType_BASE_COLOR, 0, &texture) == aiReturn_SUCCESS ||
      source.GetTexture(aiTextureType_DIFFUSE, 0, &texture) == aiReturn_SUCCESS) {
    const std::filesystem::path image = folder / texture.C_Str();
    if (holds(image.extension().string(), {".png"})) {
      material.pattern = Pattern::image;
      material.image = image.string();
    }
  }
  return material;
}

struct Loader {
  const aiScene& scene;
  const MeshPlacement& placement;
  Mesh mesh;

  Vec3f placed(const aiVector3D& p, bool is_direction) const {
    const Vec3 p_M(static_cast<double>(p.x), static_cast<double>(p.y), static_cast<double>(p.z));
    if (is_direction) return normalized(to_float(Vec3(placement.R_TM * p_M)));
    return to_float(Vec3(placement.R_TM * (placement.scale * p_M) + placement.offset_T));
  }

  void add(const aiMesh& part, const aiMatrix4x4& transform) {
    // Parts are of one kind each (SortByPType); points and lines have neither normals nor an area.
    if ((part.mPrimitiveTypes & aiPrimitiveType_TRIANGLE) == 0 || !part.HasNormals() || !part.HasPositions()) return;
    if (part.mMaterialIndex >= mesh.materials.size()) return;
    aiMatrix3x3 of_normals(transform);
    of_normals.Inverse().Transpose();
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    const bool has_image = mesh.materials[part.mMaterialIndex].pattern == Pattern::image && part.HasTextureCoords(0);
    for (unsigned i = 0; i < part.mNumVertices; ++i) {
      Vertex vertex;
      vertex.p_T = placed(transform * part.mVertices[i], false);
      vertex.normal_T = placed(of_normals * part.mNormals[i], true);
      if (has_image) {
        vertex.u = part.mTextureCoords[0][i].x;
        vertex.v = 1.0F - part.mTextureCoords[0][i].y;
      }
      mesh.vertices.push_back(vertex);
    }
    for (unsigned i = 0; i < part.mNumFaces; ++i) {
      const aiFace& face = part.mFaces[i];
      if (face.mNumIndices != 3) continue;  // lines and points
      Triangle triangle;
      triangle.material = part.mMaterialIndex;
      for (std::size_t k = 0; k < 3; ++k) triangle.corners[k] = first + face.mIndices[k];
      if (!has_image) lay_texture(triangle);
      mesh.triangles.push_back(triangle);
    }
  }

  /// Coordinates of a pattern in metres, along the two axes of T that the triangle faces least; corners of its own.
  void lay_texture(Triangle& triangle) {
    const auto& c = triangle.corners;
    const Vec3f n =
        cross(mesh.vertices[c[1]].p_T - mesh.vertices[c[0]].p_T, mesh.vertices[c[2]].p_T - mesh.vertices[c[0]].p_T);
    const float x = std::fabs(n.x);
    const float y = std::fabs(n.y);
    const float z = std::fabs(n.z);
    for (std::uint32_t& corner : triangle.corners) {
      Vertex vertex = mesh.vertices[corner];
      vertex.u = x > y && x > z ? vertex.p_T.y : vertex.p_T.x;
      vertex.v = z >= x && z >= y ? vertex.p_T.y : vertex.p_T.z;
      corner = static_cast<std::uint32_t>(mesh.vertices.size());
      mesh.vertices.push_back(vertex);
    }
  }

  void add(const aiNode& node, const aiMatrix4x4& parent) {
    const aiMatrix4x4 transform = parent * node.mTransformation;
    for (unsigned i = 0; i < node.mNumMeshes; ++i) add(*scene.mMeshes[node.mMeshes[i]], transform);
    for (unsigned i = 0; i < node.mNumChildren; ++i) add(*node.mChildren[i], transform);
  }
};

bool is_finite(Vec3f p) { return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z); }

struct CloseFile {
  void operator()(std::FILE* file) const { static_cast<void>(std::fclose(file)); }
};
using File = std::unique_ptr<std::FILE, CloseFile>;

File opened(const std::string& path) {
  File file(std::fopen(path.c_str(), "w"));
  if (!file) throw InputError(path, 0, "cannot be written", "a path in a folder that exists");
  return file;
}

}  // namespace

Bounds bounds_of(const Mesh& mesh) {
  Bounds b{mesh.vertices.at(0).p_T, mesh.vertices.at(0).p_T};
  for (const Vertex& vertex : mesh.vertices) {
    b.low_T = {std::min(b.low_T.x, vertex.p_T.x), std::min(b.low_T.y, vertex.p_T.y), std::min(b.low_T.z, vertex.p_T.z)};
    b.high_T = {std::max(b.high_T.x, vertex.p_T.x), std::max(b.high_T.y, vertex.p_T.y),
                std::max(b.high_T.z, vertex.p_T.z)};
  }
  return b;
}

Mesh load_mesh(const std::string& path, const MeshPlacement& placement) {
  if (!std::filesystem::is_regular_file(path)) throw InputError(path, 0, "no such file", expectation);
  Assimp::Importer importer;
  const aiScene* scene =
      importer.ReadFile(path, aiProcess_ValidateDataStructure | aiProcess_Triangulate | aiProcess_GenSmoothNormals |
                                  aiProcess_JoinIdenticalVertices | aiProcess_SortByPType);
  if (scene == nullptr || scene->mRootNode == nullptr) {
    throw InputError(path, 0, "cannot be read: " + in_quotes(importer.GetErrorString()), expectation);
  }
  if ((scene->mFlags & AI_SCENE_FLAGS_INCOMPLETE) != 0) throw InputError(path, 0, "is incomplete", expectation);
  Loader loader{*scene, placement, {}};
  for (unsigned i = 0; i < scene->mNumMaterials; ++i) {
    loader.mesh.materials.push_back(material_of(*scene->mMaterials[i], std::filesystem::path(path).parent_path()));
  }
  loader.add(*scene->mRootNode, aiMatrix4x4());
  if (loader.mesh.triangles.empty()) throw InputError(path, 0, "holds no triangle", expectation);
  for (const Vertex& vertex : loader.mesh.vertices) {
    if (!is_finite(vertex.p_T) || !is_finite(vertex.normal_T)) {
      throw InputError(path, 0, "holds a coordinate that is no finite number", expectation);
    }
  }
  return std::move(loader.mesh);
}

void write_obj(const Mesh& mesh, const std::string& path) {
  const std::string materials_path = std::filesystem::path(path).replace_extension(".mtl").string();
  const File materials = opened(materials_path);
  for (const Material& m : mesh.materials) {
    const double alpha = static_cast<double>(m.roughness * m.roughness);
    const double base = static_cast<double>(m.base);
    std::fprintf(materials.get(), "newmtl %s\nKd %.4f %.4f %.4f\nPm %.3f\nPr %.3f\nNs %.2f\n", m.name.c_str(), base,
                 base, base, static_cast<double>(m.metallic), static_cast<double>(m.roughness),
                 std::max(0.0, 2.0 / (alpha * alpha) - 2.0));
  }
  const File file = opened(path);
  std::fprintf(file.get(), "mtllib %s\n", std::filesystem::path(materials_path).filename().c_str());
  for (const Vertex& v : mesh.vertices) {
    std::fprintf(file.get(), "v %.6g %.6g %.6g\n", static_cast<double>(v.p_T.x), static_cast<double>(v.p_T.y),
                 static_cast<double>(v.p_T.z));
  }
  for (const Vertex& v : mesh.vertices) {
    std::fprintf(file.get(), "vn %.4g %.4g %.4g\n", static_cast<double>(v.normal_T.x),
                 static_cast<double>(v.normal_T.y), static_cast<double>(v.normal_T.z));
  }
  std::uint32_t material = ~0U;
  for (const Triangle& t : mesh.triangles) {
    if (t.material != material) std::fprintf(file.get(), "usemtl %s\n", mesh.materials.at(t.material).name.c_str());
    material = t.material;
    std::fprintf(file.get(), "f %u//%u %u//%u %u//%u\n", t.corners[0] + 1, t.corners[0] + 1, t.corners[1] + 1,
                 t.corners[1] + 1, t.corners[2] + 1, t.corners[2] + 1);
  }
  if (std::fflush(file.get()) != 0 || std::fflush(materials.get()) != 0) {
    throw InputError(path, 0, "cannot be written", "room on the disk");
  }
}

}  // namespace relnav::hil
