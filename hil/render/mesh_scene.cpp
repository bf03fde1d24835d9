#include "hil/render/mesh_scene.hpp"

#include <embree3/rtcore.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <map>
#include <mutex>
#include <numbers>
#include <numeric>
#include <stdexcept>
#include <string>

namespace relnav::hil {

struct MeshScene::Embree {
  // One thread builds: the same tree, and with it the same ties, every time.
  RTCDevice device = rtcNewDevice("threads=1");
  RTCScene scene = nullptr;

  Embree() {
    if (device == nullptr) throw std::runtime_error("Embree does not start");
    scene = rtcNewScene(device);
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);  // no ray slips between two triangles
    rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_HIGH);
  }
  ~Embree() {
    if (scene != nullptr) rtcReleaseScene(scene);
    if (device != nullptr) rtcReleaseDevice(device);
  }
  Embree(const Embree&) = delete;
  Embree& operator=(const Embree&) = delete;

  void attach(RTCGeometry geometry) const {
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
  }
};

namespace {

constexpr unsigned of_balls = 1;  // Embree numbers geometries as they come

/// Patterns are the same in every scene and take a while to make.
std::shared_ptr<const Texture> shared_texture(Pattern pattern) {
  static std::mutex mutex;
  static std::map<Pattern, std::shared_ptr<const Texture>> made;
  const std::lock_guard lock(mutex);
  auto& texture = made[pattern];
  if (!texture) texture = std::make_shared<const Texture>(make_texture(pattern));
  return texture;
}

RTCIntersectContext context_of(bool is_coherent) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = is_coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
  return context;
}

void copy_rays(const RayPacket& from, RTCRay8& to) {
  const auto copy = [](float* into, const std::array<float, RayPacket::size>& what) {
    std::memcpy(into, what.data(), sizeof what);
  };
  copy(to.org_x, from.origin_x);
  copy(to.org_y, from.origin_y);
  copy(to.org_z, from.origin_z);
  copy(to.dir_x, from.toward_x);
  copy(to.dir_y, from.toward_y);
  copy(to.dir_z, from.toward_z);
  copy(to.tfar, from.longest);
  for (std::size_t i = 0; i < RayPacket::size; ++i) {
    to.tnear[i] = 0.0F;
    to.time[i] = 0.0F;
    to.mask[i] = ~0U;
    to.id[i] = 0;
    to.flags[i] = 0;
  }
}

struct NewTriangles {
  RTCGeometry geometry;
  float* vertices;  // three each
  std::uint32_t* corners;
};
NewTriangles new_triangles(RTCDevice device, std::size_t vertices, std::size_t triangles) {
  NewTriangles made{rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE), nullptr, nullptr};
  made.vertices = static_cast<float*>(rtcSetNewGeometryBuffer(made.geometry, RTC_BUFFER_TYPE_VERTEX, 0,
                                                              RTC_FORMAT_FLOAT3, 3 * sizeof(float), vertices));
  made.corners = static_cast<std::uint32_t*>(rtcSetNewGeometryBuffer(
      made.geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(std::uint32_t), triangles));
  if (made.vertices == nullptr || made.corners == nullptr)
    throw std::runtime_error("Embree has no memory for the mesh");
  return made;
}
void put(float* vertices, std::size_t i, Vec3f p) {
  vertices[3 * i] = p.x;
  vertices[3 * i + 1] = p.y;
  vertices[3 * i + 2] = p.z;
}

/// Balls as triangles: round ones in the scene would have every ray walk a second tree, which takes two thirds longer.
RTCGeometry globes(RTCDevice device, const std::vector<Ball>& balls) {
  constexpr std::uint32_t rings = 12;
  constexpr std::uint32_t sides = 24;
  constexpr std::uint32_t points = (rings + 1) * sides;
  constexpr std::uint32_t facets = 2 * rings * sides;  // those at the poles have no area, and nothing meets them
  const auto [geometry, vertices, corners] = new_triangles(device, balls.size() * points, balls.size() * facets);
  std::size_t next = 0;
  const auto add_corners = [&, into = corners](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    for (const std::uint32_t corner : {a, b, c}) into[next++] = corner;
  };
  for (std::uint32_t k = 0; k < balls.size(); ++k) {
    for (std::uint32_t i = 0; i <= rings; ++i) {
      const float polar = std::numbers::pi_v<float> * static_cast<float>(i) / rings;
      for (std::uint32_t j = 0; j < sides; ++j) {
        const float around = 2.0F * std::numbers::pi_v<float> * static_cast<float>(j) / sides;
        const Vec3f out{std::sin(polar) * std::cos(around), std::sin(polar) * std::sin(around), std::cos(polar)};
        const std::uint32_t p = k * points + i * sides + j;
        put(vertices, p, balls[k].centre_T + balls[k].radius * out);
        if (i == rings) continue;
        const std::uint32_t q = k * points + i * sides + (j + 1) % sides;
        add_corners(p, p + sides, q);
        add_corners(q, p + sides, q + sides);
      }
    }
  }
  return geometry;
}

/// For each triangle a number that it shares with those that it shares corners with, directly or through others
/// (union-find, Tarjan, JACM 22(2), 1975).
std::vector<std::uint32_t> smooth_pieces(const Mesh& mesh) {
  std::vector<std::uint32_t> parent(mesh.vertices.size());
  std::iota(parent.begin(), parent.end(), 0U);
  const auto root = [&](std::uint32_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  for (const Triangle& t : mesh.triangles) {
    for (const std::uint32_t corner : t.corners) parent[root(corner)] = root(t.corners[0]);
  }
  std::vector<std::uint32_t> pieces;
  for (const Triangle& t : mesh.triangles) pieces.push_back(root(t.corners[0]));
  return pieces;
}

/// Balls around triangles `first` .. `last` of `order`, which is split at the median of the longer axis until `depth` is 0.
void add_parts(const Mesh& mesh, std::vector<std::uint32_t>& order, std::size_t first, std::size_t last, int depth,
               std::vector<Ball>& parts) {
  if (first == last) return;
  Vec3f low{1e30F, 1e30F, 1e30F};
  Vec3f high{-1e30F, -1e30F, -1e30F};
  const auto corners = [&](std::size_t k, auto&& visit) {
    for (const std::uint32_t corner : mesh.triangles[order[k]].corners) visit(mesh.vertices[corner].p_T);
  };
  for (std::size_t k = first; k < last; ++k) {
    corners(k, [&](Vec3f p) {
      low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
      high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
    });
  }
  if (depth == 0 || last - first < 8) {
    Ball ball{0.5F * (low + high), 0.0F};
    for (std::size_t k = first; k < last; ++k) {
      corners(k, [&](Vec3f p) { ball.radius = std::max(ball.radius, norm(p - ball.centre_T)); });
    }
    parts.push_back(ball);
    return;
  }
  const Vec3f size = high - low;
  const auto along = [&](std::uint32_t triangle) {
    float sum = 0.0F;
    for (const std::uint32_t corner : mesh.triangles[triangle].corners) {
      const Vec3f p = mesh.vertices[corner].p_T;
      sum += size.x >= size.y && size.x >= size.z ? p.x : size.y >= size.z ? p.y : p.z;
    }
    return sum;
  };
  const std::size_t middle = first + (last - first) / 2;
  const auto at = [&](std::size_t k) { return order.begin() + static_cast<std::ptrdiff_t>(k); };
  std::nth_element(at(first), at(middle), at(last),
                   [&](std::uint32_t a, std::uint32_t b) { return along(a) < along(b); });
  add_parts(mesh, order, first, middle, depth - 1, parts);
  add_parts(mesh, order, middle, last, depth - 1, parts);
}

}  // namespace

MeshScene::MeshScene(Mesh mesh, const std::vector<Ball>& balls)
    : embree_(std::make_unique<Embree>()), mesh_(std::move(mesh)) {
  for (const Material& material : mesh_.materials) {
    if (material.pattern == Pattern::plain) {
      textures_.emplace_back();
    } else if (material.pattern == Pattern::image) {
      textures_.push_back(std::make_shared<const Texture>(load_texture(material.image)));
    } else {
      textures_.push_back(shared_texture(material.pattern));
    }
  }
  for (const Triangle& triangle : mesh_.triangles) {
    const Vertex& a = mesh_.vertices[triangle.corners[0]];
    const Vertex& b = mesh_.vertices[triangle.corners[1]];
    const Vertex& c = mesh_.vertices[triangle.corners[2]];
    const Vec3f ab = b.p_T - a.p_T;
    const Vec3f ac = c.p_T - a.p_T;
    const float det = (b.u - a.u) * (c.v - a.v) - (c.u - a.u) * (b.v - a.v);
    const Vec3f across = cross(ab, ac);
    const float area = norm(across);
    facets_.push_back({normalized(across), triangle.material});
    laid_.push_back({normalized(std::copysign(1.0F, det) * ((c.v - a.v) * ab - (b.v - a.v) * ac)),
                     area > 0.0F ? std::sqrt(std::fabs(det) / area) : 1.0F});
  }

  const auto [triangles, vertices, corners] =
      new_triangles(embree_->device, mesh_.vertices.size(), mesh_.triangles.size());
  for (std::size_t i = 0; i < mesh_.vertices.size(); ++i) put(vertices, i, mesh_.vertices[i].p_T);
  for (std::size_t i = 0; i < mesh_.triangles.size(); ++i) {
    std::copy_n(mesh_.triangles[i].corners.begin(), 3, corners + 3 * i);
  }
  embree_->attach(triangles);

  if (!balls.empty()) embree_->attach(globes(embree_->device, balls));
  rtcCommitScene(embree_->scene);
  if (rtcGetDeviceError(embree_->device) != RTC_ERROR_NONE) throw std::runtime_error("Embree cannot take the mesh");

  pieces_ = smooth_pieces(mesh_);
  std::vector<std::uint32_t> order(mesh_.triangles.size());
  std::iota(order.begin(), order.end(), 0U);
  add_parts(mesh_, order, 0, order.size(), 5, parts_);
  parts_.insert(parts_.end(), balls.begin(), balls.end());
  const Bounds box = bounds_of(mesh_);
  bounds_.centre_T = 0.5F * (box.low_T + box.high_T);
  for (const Vertex& vertex : mesh_.vertices) {
    bounds_.radius = std::max(bounds_.radius, norm(vertex.p_T - bounds_.centre_T));
  }
  for (const Ball& ball : balls) {
    bounds_.radius = std::max(bounds_.radius, norm(ball.centre_T - bounds_.centre_T) + ball.radius);
  }
}

MeshScene::~MeshScene() = default;

void MeshScene::trace(const RayPacket& rays, std::array<Hit, RayPacket::size>& met) const {
  RTCIntersectContext context = context_of(true);
  RTCRayHit8 query;
  copy_rays(rays, query.ray);
  for (unsigned& id : query.hit.geomID) id = RTC_INVALID_GEOMETRY_ID;
  for (unsigned& id : query.hit.instID[0]) id = RTC_INVALID_GEOMETRY_ID;
  rtcIntersect8(rays.is_used.data(), embree_->scene, &context, &query);
  for (std::size_t i = 0; i < RayPacket::size; ++i) {
    Hit& hit = met[i];
    if (rays.is_used[i] == 0 || query.hit.geomID[i] == RTC_INVALID_GEOMETRY_ID) {
      hit.material = Hit::nothing;
      continue;
    }
    const Vec3f toward_T{rays.toward_x[i], rays.toward_y[i], rays.toward_z[i]};
    const Vec3f origin_T{rays.origin_x[i], rays.origin_y[i], rays.origin_z[i]};
    hit.depth = query.ray.tfar[i];
    hit.p_T = origin_T + hit.depth * toward_T;
    if (query.hit.geomID[i] == of_balls) {
      hit.material = Hit::ball;
      hit.triangle = 0;
      hit.face_T = normalized({query.hit.Ng_x[i], query.hit.Ng_y[i], query.hit.Ng_z[i]});
      continue;
    }
    hit.triangle = query.hit.primID[i];
    hit.weight_b = query.hit.u[i];
    hit.weight_c = query.hit.v[i];
    const Facet& facet = facets_[hit.triangle];
    hit.material = facet.material;
    hit.face_T = dot(facet.face_T, toward_T) > 0.0F ? -facet.face_T : facet.face_T;
  }
}

void MeshScene::describe(const Hit& hit, Vec3f to_viewer_T, float lit, float footprint, Patches& patches,
                         std::size_t i) const {
  const Triangle& triangle = mesh_.triangles[hit.triangle];
  const Vertex& a = mesh_.vertices[triangle.corners[0]];
  const Vertex& b = mesh_.vertices[triangle.corners[1]];
  const Vertex& c = mesh_.vertices[triangle.corners[2]];
  const float wb = hit.weight_b;
  const float wc = hit.weight_c;
  const float wa = 1.0F - wb - wc;
  const Material& material = mesh_.materials[triangle.material];
  const Laid& laid = laid_[hit.triangle];
  const auto put = [i](Patches::Numbers& x, Patches::Numbers& y, Patches::Numbers& z, Vec3f value) {
    x[i] = value.x;
    y[i] = value.y;
    z[i] = value.z;
  };
  put(patches.normal_x, patches.normal_y, patches.normal_z, wa * a.normal_T + wb * b.normal_T + wc * c.normal_T);
  put(patches.face_x, patches.face_y, patches.face_z, hit.face_T);
  put(patches.along_x, patches.along_y, patches.along_z, laid.along_u_T);
  put(patches.viewer_x, patches.viewer_y, patches.viewer_z, to_viewer_T);
  const float width = material.roughness * material.roughness;
  patches.metallic[i] = material.metallic;
  patches.emission[i] = material.emission;
  patches.lit[i] = lit;
  Texel texel;
  if (const Texture* texture = textures_[triangle.material].get()) {
    // The longer axis of the footprint grows with 1 / facing, the shorter does not: in between.
    const float facing = std::max(dot(hit.face_T, to_viewer_T), 0.05F);
    texel = texture->at(wa * a.u + wb * b.u + wc * c.u, wa * a.v + wb * b.v + wc * c.v,
                        footprint * laid.per_metre / std::sqrt(facing));
  }
  patches.base[i] = std::min(material.base * texel.base(), 1.0F);
  patches.alpha2[i] = width * width + texel.alpha2();
  patches.tilt_u[i] = texel.tilt_u();
  patches.tilt_v[i] = texel.tilt_v();
}

std::uint32_t MeshScene::blocked(const RayPacket& rays, bool is_coherent) const {
  RTCIntersectContext context = context_of(is_coherent);
  RTCRay8 query;
  copy_rays(rays, query);
  rtcOccluded8(rays.is_used.data(), embree_->scene, &context, &query);
  std::uint32_t bits = 0;
  for (std::size_t i = 0; i < RayPacket::size; ++i) {
    if (rays.is_used[i] != 0 && query.tfar[i] < 0.0F) bits |= 1U << i;
  }
  return bits;
}

bool MeshScene::encloses(Vec3f p_T) const {
  const float reach = norm(p_T - bounds_.centre_T);
  if (reach >= bounds_.radius) return false;
  // Evenly over the sphere (Fibonacci lattice; Gonzalez, Mathematical Geosciences 42, 2010).
  constexpr std::size_t packets = 8;
  constexpr double golden_rad = 2.399963229728653;
  for (std::size_t packet = 0; packet < packets; ++packet) {
    RayPacket rays;
    for (std::size_t i = 0; i < RayPacket::size; ++i) {
      const auto k = static_cast<double>(packet * RayPacket::size + i);
      const double z = 1.0 - (2.0 * k + 1.0) / static_cast<double>(packets * RayPacket::size);
      const double r = std::sqrt(1.0 - z * z);
      rays.set(i, p_T, to_float(Vec3(r * std::cos(golden_rad * k), r * std::sin(golden_rad * k), z)),
               reach + bounds_.radius);
    }
    if (blocked(rays, false) != 0xFFU) return false;
  }
  return true;
}

}  // namespace relnav::hil
