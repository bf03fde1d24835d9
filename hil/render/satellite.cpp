#include "hil/render/satellite.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "hil/render/hash.hpp"
#include "hil/render/mesh_builder.hpp"

namespace relnav::hil {
namespace {

const Vec3 bus_half(0.65, 0.60, 0.70);
constexpr double chamfer = 0.16;

struct Materials {
  std::uint32_t foil, dark_foil, white, black, aluminium, nozzle, cells, carbon, label, paint;
};

Materials add_materials(MeshBuilder& b) {
  Materials m{};
  m.foil = b.add_material({"foil", 0.9F, 0.9F, 0.46F, 0.0F, Pattern::foil, {}});
  m.dark_foil = b.add_material({"black_foil", 0.16F, 0.2F, 0.5F, 0.0F, Pattern::foil, {}});
  m.white = b.add_material({"white_paint", 0.75F, 0.0F, 0.7F, 0.0F, Pattern::panel, {}});
  m.black = b.add_material({"black_paint", 0.05F, 0.0F, 0.5F, 0.0F, Pattern::plain, {}});
  m.aluminium = b.add_material({"aluminium", 0.75F, 0.7F, 0.6F, 0.0F, Pattern::panel, {}});
  m.nozzle = b.add_material({"nozzle", 0.35F, 0.8F, 0.45F, 0.0F, Pattern::plain, {}});
  m.cells = b.add_material({"solar_cells", 0.05F, 0.0F, 0.3F, 0.0F, Pattern::solar_cells, {}});
  m.carbon = b.add_material({"carbon", 0.08F, 0.0F, 0.45F, 0.0F, Pattern::panel, {}});
  m.label = b.add_material({"label", 0.8F, 0.0F, 0.8F, 0.0F, Pattern::labels, {}});
  m.paint = b.add_material({"grey_paint", 0.35F, 0.0F, 0.6F, 0.0F, Pattern::panel, {}});
  return m;
}

/// Prism with eight sides: broad ones in foil, those between painted.
void add_bus(MeshBuilder& b, const Materials& m) {
  const double x = bus_half.x();
  const double y = bus_half.y();
  const std::vector<Vec3> outline{{x, -y + chamfer, 0},  {x, y - chamfer, 0},  {x - chamfer, y, 0},
                                  {-x + chamfer, y, 0},  {-x, y - chamfer, 0}, {-x, -y + chamfer, 0},
                                  {-x + chamfer, -y, 0}, {x - chamfer, -y, 0}};
  const Vec3 up(0.0, 0.0, bus_half.z());
  std::vector<Vec3f> front;
  std::vector<Vec3f> back;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Vec3& p = outline[i];
    const Vec3& q = outline[(i + 1) % outline.size()];
    b.add_polygon({to_float(Vec3(p - up)), to_float(Vec3(q - up)), to_float(Vec3(q + up)), to_float(Vec3(p + up))},
                  i % 2 == 0 ? m.foil : m.white);
    back.push_back(to_float(Vec3(p + up)));
    front.insert(front.begin(), to_float(Vec3(p - up)));
    // Edges in aluminium.
    b.add_rod(p - up, p + up, 0.012, m.aluminium, 8);
    b.add_rod(p - up, q - up, 0.012, m.aluminium, 8);
    b.add_rod(p + up, q + up, 0.012, m.aluminium, 8);
  }
  b.add_polygon(front, m.foil);
  b.add_polygon(back, m.foil);
}

void add_docking_face(MeshBuilder& b, const Materials& m) {
  const Vec3 face(0.0, 0.0, -bus_half.z());
  const Vec3 out(0.0, 0.0, -1.0);
  b.add_turned(face, out, {{0.47, 0.0}, {0.47, 0.09}, {0.49, 0.11}, {0.49, 0.13}, {0.42, 0.13}, {0.42, 0.0}},
               m.aluminium, 64);
  for (int i = 0; i < 24; ++i) {  // bolts
    const double angle = 2.0 * std::numbers::pi * (i + 0.5) / 24.0;
    const Vec3 at = face + Vec3(0.455 * std::cos(angle), 0.455 * std::sin(angle), -0.13);
    b.add_rod(at, at + 0.012 * out, 0.011, m.black, 8);
  }
  for (int i = 0; i < 3; ++i) {  // petals
    const double angle = 2.0 * std::numbers::pi * i / 3.0 + 0.3;
    const Vec3 radial(std::cos(angle), std::sin(angle), 0.0);
    Mat3 R_TP;
    R_TP << radial.x(), -radial.y(), 0, radial.y(), radial.x(), 0, 0, 0, 1;
    b.add_box(face + 0.40 * radial + 0.17 * out, Vec3(0.03, 0.14, 0.10), m.white, R_TP);
  }
  // Nozzle: bell, wall and throat.
  b.add_turned(face, out,
               {{0.13, 0.0}, {0.12, 0.03}, {0.09, 0.06}, {0.13, 0.12}, {0.18, 0.19}, {0.215, 0.26}, {0.235, 0.32}},
               m.nozzle, 48);
  b.add_turned(face, out,
               {{0.235, 0.32}, {0.225, 0.32}, {0.205, 0.26}, {0.17, 0.19}, {0.12, 0.12}, {0.05, 0.05}, {0.0, 0.05}},
               m.nozzle, 48);
  b.add_turned(face, out, {{0.36, 0.0}, {0.36, 0.02}, {0.30, 0.02}, {0.0, 0.005}}, m.dark_foil, 48);

  // Boxes around the ring, all of different kinds.
  b.add_box(face + Vec3(0.0, -0.53, -0.06), Vec3(0.46, 0.08, 0.12), m.white);
  b.add_box(face + Vec3(-0.56, 0.02, -0.05), Vec3(0.11, 0.34, 0.10), m.white);
  b.add_box(face + Vec3(0.57, -0.05, -0.045), Vec3(0.10, 0.22, 0.09), m.paint);
  b.add_box(face + Vec3(0.08, 0.54, -0.04), Vec3(0.36, 0.07, 0.08), m.paint);
  b.add_box(face + Vec3(-0.40, 0.42, -0.004), Vec3(0.15, 0.15, 0.008), m.label);
  b.add_box(face + Vec3(0.42, -0.42, -0.004), Vec3(0.15, 0.15, 0.008), m.label);
  b.add_box(face + Vec3(0.44, 0.40, -0.02), Vec3(0.12, 0.09, 0.04), m.black);
  b.add_box(face + Vec3(-0.42, -0.40, -0.03), Vec3(0.10, 0.10, 0.06), m.aluminium);
  b.add_rod(face + Vec3(-0.42, -0.40, -0.06), face + Vec3(-0.42, -0.40, -0.14), 0.035, m.black, 20);
  b.add_rod(face + Vec3(0.25, -0.60, -0.03), face + Vec3(0.60, -0.32, -0.03), 0.009, m.white, 8);  // handrail
  b.add_rod(face + Vec3(-0.60, 0.28, -0.03), face + Vec3(-0.30, 0.57, -0.03), 0.009, m.white, 8);
}

void add_wing(MeshBuilder& b, const Materials& m, double side) {
  const double root = bus_half.y();
  const double tilt = 0.20;  // about y: cells look toward -Z, and a little to the side
  Mat3 R_TP;
  R_TP << std::cos(tilt), 0, std::sin(tilt), 0, 1, 0, -std::sin(tilt), 0, std::cos(tilt);
  const auto at = [&](double x, double y, double z) { return Vec3(R_TP * Vec3(x, side * y, z)); };
  b.add_rod(at(0.0, root, 0.0), at(0.35, root + 0.38, 0.0), 0.018, m.white);
  b.add_rod(at(0.0, root, 0.0), at(-0.35, root + 0.38, 0.0), 0.018, m.white);
  b.add_rod(at(-0.40, root + 0.38, 0.0), at(0.40, root + 0.38, 0.0), 0.016, m.aluminium);
  for (int panel = 0; panel < 2; ++panel) {
    const double y = root + 0.40 + 0.81 * panel + 0.39;
    b.add_box(at(0.0, y, 0.0), Vec3(0.86, 0.78, 0.022), m.carbon, R_TP);
    const double z = -0.0125;
    std::vector<Vec3f> cells{to_float(at(-0.415, y - 0.375, z)), to_float(at(-0.415, y + 0.375, z)),
                             to_float(at(0.415, y + 0.375, z)), to_float(at(0.415, y - 0.375, z))};
    if (side < 0.0) std::reverse(cells.begin(), cells.end());
    b.add_polygon(cells, m.cells);
    for (const double x : {-0.3, 0.3}) b.add_box(at(x, y + 0.40, 0.0), Vec3(0.05, 0.05, 0.04), m.aluminium, R_TP);
  }
}

void add_sides(MeshBuilder& b, const Materials& m) {
  // Dish on +X, its feed on three struts.
  const Vec3 dish(bus_half.x() + 0.16, 0.0, 0.15);
  const Vec3 axis = Vec3(0.9, -0.1, -0.42).normalized();
  b.add_rod(Vec3(bus_half.x(), 0.0, 0.15), dish, 0.03, m.aluminium);
  std::vector<MeshBuilder::Turn> bowl;
  for (int i = 0; i <= 10; ++i) bowl.push_back({0.036 * i, 0.9 * 0.036 * i * 0.036 * i});
  std::vector<MeshBuilder::Turn> inside(bowl.rbegin(), bowl.rend());
  for (MeshBuilder::Turn& turn : inside) turn.along += 0.004;
  b.add_turned(dish, axis, bowl, m.carbon, 48);
  b.add_turned(dish, axis, inside, m.white, 48);
  for (int i = 0; i < 3; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / 3.0;
    Vec3f s;
    Vec3f t;
    base_around(to_float(axis), s, t);
    const Vec3 rim = dish + 0.11 * axis + 0.33 * (std::cos(angle) * to_double(s) + std::sin(angle) * to_double(t));
    b.add_rod(rim, dish + 0.33 * axis, 0.006, m.black, 6);
  }
  b.add_turned(dish + 0.30 * axis, axis, {{0.0, 0.0}, {0.045, 0.0}, {0.03, 0.06}, {0.0, 0.06}}, m.aluminium);

  // Boxes, plates and radiators on the sides.
  b.add_box(Vec3(-bus_half.x() - 0.004, 0.0, 0.15), Vec3(0.008, 0.6, 0.55), m.white);
  b.add_box(Vec3(-bus_half.x() - 0.05, -0.22, -0.42), Vec3(0.10, 0.22, 0.26), m.paint);
  b.add_box(Vec3(-bus_half.x() - 0.006, 0.25, -0.45), Vec3(0.012, 0.15, 0.15), m.label);
  b.add_box(Vec3(bus_half.x() + 0.05, 0.24, -0.40), Vec3(0.10, 0.24, 0.20), m.white);
  b.add_box(Vec3(bus_half.x() + 0.006, -0.28, -0.45), Vec3(0.012, 0.15, 0.15), m.label);
  b.add_box(Vec3(0.30, -bus_half.y() - 0.04, -0.35), Vec3(0.30, 0.08, 0.30), m.aluminium);
  b.add_box(Vec3(-0.28, -bus_half.y() - 0.006, -0.40), Vec3(0.15, 0.012, 0.15), m.label);
  b.add_box(Vec3(-0.30, bus_half.y() + 0.05, -0.30), Vec3(0.24, 0.10, 0.34), m.white);
  b.add_box(Vec3(0.28, bus_half.y() + 0.006, -0.45), Vec3(0.15, 0.012, 0.15), m.label);
  b.add_box(Vec3(0.1, 0.1, bus_half.z() + 0.06), Vec3(0.5, 0.4, 0.12), m.aluminium);
  b.add_box(Vec3(-0.42, -0.35, bus_half.z() + 0.004), Vec3(0.15, 0.15, 0.008), m.label);
  // Star tracker's baffle, rods.
  b.add_turned(Vec3(-0.40, -bus_half.y(), 0.30), Vec3(-0.3, -0.8, 0.5).normalized(),
               {{0.05, 0.0}, {0.08, 0.22}, {0.07, 0.22}, {0.04, 0.02}, {0.0, 0.02}}, m.black);
  b.add_rod(Vec3(0.45, bus_half.y(), 0.5), Vec3(0.75, bus_half.y() + 0.45, 0.75), 0.006, m.white, 6);
  b.add_rod(Vec3(-0.6, 0.5, bus_half.z()), Vec3(-0.9, 0.8, bus_half.z() + 0.5), 0.006, m.white, 6);

  // Thrusters at the corners, in pairs.
  for (const double x : {-1.0, 1.0}) {
    for (const double y : {-1.0, 1.0}) {
      for (const double z : {-1.0, 1.0}) {
        const Vec3 corner(x * (bus_half.x() - 0.5 * chamfer), y * (bus_half.y() - 0.5 * chamfer),
                          z * (bus_half.z() - 0.08));
        const Vec3 out = Vec3(x, y, 0.35 * z).normalized();
        b.add_rod(corner, corner + 0.05 * out, 0.03, m.aluminium);
        b.add_turned(corner + 0.05 * out, out, {{0.015, 0.0}, {0.04, 0.09}, {0.036, 0.09}, {0.012, 0.01}, {0.0, 0.01}},
                     m.nozzle, 20);
      }
    }
  }
}

/// Screws and tapes that nobody planned: what corners are found on.
void add_small_parts(MeshBuilder& b, const Materials& m) {
  for (std::uint32_t i = 0; i < 90; ++i) {
    const auto draw = [&](std::uint32_t k) { return 2.0 * static_cast<double>(unit_hash(i, 100U + k)) - 1.0; };
    const int axis = static_cast<int>(i % 3);
    const double side = (i / 3) % 2 == 0 ? -1.0 : 1.0;
    Vec3 p(draw(0) * (bus_half.x() - 0.2), draw(1) * (bus_half.y() - 0.2), draw(2) * (bus_half.z() - 0.06));
    if (axis == 2) p = Vec3(draw(0) * (bus_half.x() - 0.06), draw(1) * (bus_half.y() - 0.06), 0.0);
    if (axis == 2 && std::hypot(p.x(), p.y()) > 0.62) continue;
    if (axis == 2 && std::hypot(p.x(), p.y()) < 0.5 && side < 0.0) continue;
    p(axis) = side * bus_half(axis);
    const std::uint32_t material = i % 4 == 0 ? m.black : i % 4 == 1 ? m.white : m.aluminium;
    Vec3 size(0.03 + 0.03 * std::fabs(draw(3)), 0.03 + 0.03 * std::fabs(draw(4)), 0.03);
    if (i % 5 == 0) size((axis + 1) % 3) += 0.12;
    size(axis) = 0.012;
    b.add_box(p, size, material);
  }
}

void add_brackets(MeshBuilder& b, const Materials& m, const TargetModel& lights) {
  for (const TargetFeature& light : lights.features) {
    const Vec3 foot = light.p_T.cwiseMax(-bus_half).cwiseMin(bus_half);
    const Vec3 bracket = foot - light.p_T;
    if (bracket.norm() <= light_radius) continue;
    b.add_rod(light.p_T + 0.9 * light_radius * bracket.normalized(), foot, 0.007, m.black, 8);
    b.add_rod(foot, foot - 0.02 * bracket.normalized(), 0.025, m.aluminium, 12);
  }
}

}  // namespace

Mesh make_satellite(const TargetModel* lights) {
  MeshBuilder builder;
  const Materials materials = add_materials(builder);
  add_bus(builder, materials);
  add_docking_face(builder, materials);
  add_wing(builder, materials, 1.0);
  add_wing(builder, materials, -1.0);
  add_sides(builder, materials);
  add_small_parts(builder, materials);
  if (lights != nullptr) add_brackets(builder, materials, *lights);
  return std::move(builder.mesh());
}

}  // namespace relnav::hil
