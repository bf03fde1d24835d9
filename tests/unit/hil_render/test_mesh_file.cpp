// Meshes from files, and the one made in code.
#include <fstream>

#include "hil/render/mesh_file.hpp"
#include "hil/render/satellite.hpp"
#include "hil/scenarios/targets.hpp"
#include "platform/files/input_error.hpp"
#include "tests/unit/hil_render/scene_case.hpp"

#include "tests/support/scratch.hpp"  // last: CppUTest redefines operators

#include <CppUTest/TestHarness.h>

using namespace relnav;
using namespace relnav::hil;
using namespace relnav::test;

namespace {

double area_of(const Mesh& mesh) {
  double area = 0.0;
  for (const Triangle& t : mesh.triangles) {
    const Vec3f a = mesh.vertices[t.corners[0]].p_T;
    area += 0.5 *
            static_cast<double>(norm(cross(mesh.vertices[t.corners[1]].p_T - a, mesh.vertices[t.corners[2]].p_T - a)));
  }
  return area;
}

}  // namespace

TEST_GROUP(RenderMeshFile) {
  Scratch scratch;

  void write(const std::string& path, const std::string& text) { std::ofstream(path) << text; }
  std::string error_of(const std::string& path) {
    try {
      static_cast<void>(load_mesh(path));
    } catch (const InputError& error) {
      return error.what();
    }
    return {};
  }
  void check_named(const std::string& path) {
    const std::string error = error_of(path);
    CHECK_TEXT(error.find(path) == 0, error.c_str());
    CHECK_TEXT(error.find('\n') == std::string::npos, error.c_str());
  }
};

TEST(RenderMeshFile, AMissingBrokenOrEmptyMeshIsNamed) {
  check_named(scratch.path("none.obj"));
  write(scratch.path("broken.gltf"), "{ \"asset\": { \"version\": ");
  check_named(scratch.path("broken.gltf"));
  write(scratch.path("broken.stl"), "solid x\n facet normal 0 0");
  check_named(scratch.path("broken.stl"));
  write(scratch.path("empty.obj"), "");
  check_named(scratch.path("empty.obj"));
  write(scratch.path("points.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\n");
  check_named(scratch.path("points.obj"));
  write(scratch.path("lines.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nl 1 2 3\n");
  check_named(scratch.path("lines.obj"));
  write(scratch.path("notes.txt"), "no mesh");
  check_named(scratch.path("notes.txt"));
  write(scratch.path("range.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n");
  check_named(scratch.path("range.obj"));
  write(scratch.path("nan.obj"), "v 0 0 0\nv nan 0 0\nv 0 1 0\nf 1 2 3\n");
  check_named(scratch.path("nan.obj"));
}

TEST(RenderMeshFile, PlacementIsAppliedAndMaterialsAreRead) {
  write(scratch.path("a.mtl"),
        "newmtl gold_foil\nKd 0.8 0.8 0.8\nPr 0.4\nPm 1.0\nnewmtl plain\nKd 0.2 0.2 0.2\nNs 100\n");
  write(scratch.path("a.obj"),
        "mtllib a.mtl\nv 0 0 0\nv 100 0 0\nv 0 200 0\nusemtl gold_foil\nf 1 2 3\nusemtl plain\nf 1 3 2\n");
  MeshPlacement placement;
  placement.scale = 0.01;
  placement.R_TM << 0, -1, 0, 1, 0, 0, 0, 0, 1;  // x becomes y
  placement.offset_T = Vec3(0.0, 0.0, 0.5);
  const Mesh mesh = load_mesh(scratch.path("a.obj"), placement);
  CHECK_EQUAL(2U, mesh.triangles.size());
  const Bounds box = bounds_of(mesh);
  DOUBLES_EQUAL(-2.0, static_cast<double>(box.low_T.x), 1e-5);
  DOUBLES_EQUAL(1.0, static_cast<double>(box.high_T.y), 1e-5);
  DOUBLES_EQUAL(0.5, static_cast<double>(box.low_T.z), 1e-5);
  bool foil = false;
  for (const Triangle& triangle : mesh.triangles) {
    const Material& material = mesh.materials[triangle.material];
    if (material.pattern != Pattern::foil) continue;
    foil = true;
    DOUBLES_EQUAL(0.8, static_cast<double>(material.base), 1e-3);
  }
  CHECK(foil);
}

TEST(RenderMeshFile, OurSatelliteSurvivesBeingWritten) {
  const TargetModel lights = square_target(0.5);
  const Mesh mesh = make_satellite(&lights);
  CHECK(mesh.triangles.size() > 2000);
  const Bounds box = bounds_of(mesh);
  CHECK(box.high_T.y > 2.0F && box.high_T.y < 3.0F);
  CHECK(box.low_T.z > -1.3F);
  write_obj(mesh, scratch.path("s.obj"));
  const Mesh again = load_mesh(scratch.path("s.obj"));
  CHECK(again.triangles.size() > mesh.triangles.size() * 99 / 100);
  DOUBLES_EQUAL(static_cast<double>(box.high_T.y), static_cast<double>(bounds_of(again).high_T.y), 1e-4);
  DOUBLES_EQUAL(1.0, area_of(again) / area_of(mesh), 1e-3);
  CHECK_THROWS(InputError, write_obj(mesh, scratch.path("no/such/folder.obj")));
}

TEST(RenderMeshFile, ARendererSaysWhichMeshItCannotUse) {
  RenderSettings settings = plain_settings();
  settings.mesh = scratch.path("none.glb");
  CHECK_THROWS(InputError, SceneRenderer(settings, camera_of(64, 48, 60.0, false), nullptr, 1));
  settings.mesh.clear();
  CHECK_THROWS(std::invalid_argument, SceneRenderer(settings, CameraModel{}, nullptr, 1));
}

TEST(RenderMeshFile, TexturesComeFromPngFilesBesideTheMesh) {
  Image image;
  image.width_px = image.height_px = 4;
  for (int i = 0; i < 16; ++i) image.bytes.push_back(i % 4 < 2 ? 255 : 0);
  const auto png = encode_png(image);
  std::ofstream(scratch.path("t.png"), std::ios::binary)
      .write(reinterpret_cast<const char*>(png.data()), static_cast<std::streamsize>(png.size()));
  write(scratch.path("t.mtl"), "newmtl m\nKd 1 1 1\nPr 1\nmap_Kd t.png\n");
  write(scratch.path("t.obj"),
        "mtllib t.mtl\nv -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nusemtl m\nf 1/1 2/2 "
        "3/3\nf 1/1 3/3 4/4\n");
  RenderSettings settings = plain_settings();
  settings.mesh = scratch.path("t.obj");
  SceneRenderer renderer(settings, camera_of(160, 120, 100.0, false), nullptr, 1);
  const Image seen = rendered(renderer, ahead(4.0));
  CHECK(level(seen, 82 - 12, 56) > 10'000.0);
  CHECK(level(seen, 82 + 12, 56) < 1000.0);
  std::ofstream(scratch.path("t.png")) << "no image";
  CHECK_THROWS(InputError, SceneRenderer(settings, camera_of(64, 48, 60.0, false), nullptr, 1));
}
