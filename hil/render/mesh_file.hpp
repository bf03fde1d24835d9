#pragma once
#include <string>

#include "hil/render/mesh.hpp"

namespace relnav::hil {

/// How a file's coordinates become those of T: p_T = R_TM (scale p_M) + offset_T.
struct MeshPlacement {
  double scale = 1.0;  ///< metres in the file's unit
  Mat3 R_TM = Mat3::Identity();
  Vec3 offset_T = Vec3::Zero();  ///< m
};

/// Any file that Assimp knows (glTF, OBJ, STL, ...), all of its nodes. Materials as far as the file tells them; a name that
/// holds `foil`, `mli` or `blanket` gets crinkled foil, `cell` or `solar` solar cells. Textures: base colour from a PNG
/// file beside the mesh. Throws InputError when the file is missing or broken, or holds no triangle.
[[nodiscard]] Mesh load_mesh(const std::string& path, const MeshPlacement& placement = {});

/// Wavefront OBJ and its materials (`path` with .mtl for .obj). Throws InputError when it cannot be written.
void write_obj(const Mesh& mesh, const std::string& path);

}  // namespace relnav::hil
