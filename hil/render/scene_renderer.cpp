#include "hil/render/scene_renderer.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "hil/render/hash.hpp"
#include "hil/render/lighting.hpp"
#include "hil/render/marker_lights.hpp"
#include "hil/render/mesh_scene.hpp"
#include "hil/render/point_spread.hpp"
#include "hil/render/ray_table.hpp"
#include "hil/render/satellite.hpp"
#include "hil/render/sensor.hpp"
#include "hil/render/sky.hpp"
#include "hil/render/view.hpp"
#include "hil/render/worker_pool.hpp"

namespace relnav::hil {
namespace {

constexpr std::size_t packet = RayPacket::size;
constexpr std::uint32_t tile_width = 32;
constexpr std::uint32_t tile_height = 16;

/// What a pixel's central ray met: as much of it as tells whether an edge runs between it and its neighbour. Small, since
/// all pixels write and read one.
struct Seen {
  std::uint32_t triangle = 0;
  float depth = 0.0F;
  float radiance = 0.0F;
  std::uint32_t material = Hit::nothing;  // and marks
  static constexpr std::uint32_t lit = 0x80000000U;
  static constexpr std::uint32_t faces_sun = 0x40000000U;
};

/// A rectangle of pixels and the cone that their rays fill.
struct Tile {
  std::uint32_t u0, v0, u1, v1;
  Vec3f axis_C{};
  float half_angle = 0.0F;
  bool is_seen = false;
};

std::vector<Ball> balls_of(const TargetModel* lights) {
  std::vector<Ball> balls;
  if (lights == nullptr) return balls;
  for (const TargetFeature& light : lights->features) {
    balls.push_back({to_float(light.p_T), static_cast<float>(light_radius)});
  }
  return balls;
}

std::vector<Tile> tiles_of(const RayTable& rays) {
  std::vector<Tile> tiles;
  for (std::uint32_t v = 0; v < rays.height(); v += tile_height) {
    for (std::uint32_t u = 0; u < rays.width(); u += tile_width) {
      Tile tile{u,    v,    std::min(u + tile_width, rays.width()), std::min(v + tile_height, rays.height()), {},
                0.0F, false};
      Vec3f sum{};
      for (std::uint32_t y = tile.v0; y < tile.v1; ++y) {
        for (std::uint32_t x = tile.u0; x < tile.u1; ++x) {
          if (!rays.is_seen(x, y)) continue;
          sum = sum + rays.centre(x, y);
          tile.is_seen = true;
        }
      }
      tile.axis_C = normalized(sum);
      for (std::uint32_t y = tile.v0; y < tile.v1; ++y) {
        for (std::uint32_t x = tile.u0; x < tile.u1; ++x) {
          if (!rays.is_seen(x, y)) continue;
          const float angle = std::acos(std::clamp(dot(tile.axis_C, rays.centre(x, y)), -1.0F, 1.0F));
          tile.half_angle = std::max(tile.half_angle, angle + 2.0F * rays.pixel_angle(x, y));
        }
      }
      tiles.push_back(tile);
    }
  }
  return tiles;
}

/// Where in a pixel a ray goes, -0.5 .. 0.5, and where on the sun's disc its shadow's ray, in radii.
struct SamplePlace {
  float du, dv;
  float sun_s, sun_t;
};
/// Hammersley's points (Niederreiter, 1992, chapter 3): no two of them share a column or a row. Centred, as radical inverses
/// are short of a half by half a step on average.
std::vector<SamplePlace> sample_places(std::uint32_t n) {
  std::vector<SamplePlace> places;
  std::uint32_t power = 1;
  while (power < n) power *= 2;
  const auto count = static_cast<float>(n);
  for (std::uint32_t i = 0; i < n; ++i) {
    float inverse = 0.5F / static_cast<float>(power);
    float digit = 0.5F;
    for (std::uint32_t k = i; k != 0; k >>= 1U, digit *= 0.5F) inverse += (k & 1U) != 0U ? digit : 0.0F;
    const float radius = std::sqrt((static_cast<float>((i * 5U + 3U) % n) + 0.5F) / count);
    const float angle = 2.39996323F * static_cast<float>(i);  // the golden angle
    places.push_back({(static_cast<float>(i) + 0.5F) / count - 0.5F, inverse - 0.5F, radius * std::cos(angle),
                      radius * std::sin(angle)});
  }
  return places;
}

/// Rays of a pixel that met the same piece of surface, which is shaded once.
struct Cluster {
  Hit hit;  // the first of them; its place, and that on its triangle, become sums
  float rays;
  float lit;
  float same_triangle;
};

}  // namespace

struct SceneRenderer::State {
  RenderSettings settings;
  CameraModel camera;
  TargetModel lights;
  RayTable rays;
  MeshScene scene;
  WorkerPool pool;
  PointSpreadFilter spread;
  Sensor sensor;
  std::vector<Tile> tiles;
  std::vector<char> shows_target;  // each tile, at this instant: a ray met it
  std::vector<Seen> seen;
  std::vector<float> behind;  // radiance of the sky in each pixel
  static constexpr std::size_t sun_bases = 32;
  std::array<Vec3f, 2 * sun_bases> sun_base_T;  // pairs across the way to the sun, as long as its radius, each turned
  Plane now;                                    // an instant
  Plane sharp;                                  // the exposure
  Plane points;                                 // lights and stars, spread
  Plane blurred;

  State(const RenderSettings& s, const CameraModel& c, const TargetModel* l, std::uint64_t seed, Mesh mesh)
      : settings(s),
        camera(c),
        lights(l != nullptr ? *l : TargetModel{}),
        rays(c),
        scene(std::move(mesh), balls_of(l)),
        pool(s.threads),
        spread(s.spread, rays.width(), rays.height()),
        sensor(s.sensor, rays.width(), rays.height(), seed),
        tiles(tiles_of(rays)),
        shows_target(tiles.size()),
        seen(static_cast<std::size_t>(rays.width()) * rays.height()),
        behind(seen.size()) {
    for (Plane* plane : {&now, &sharp, &points, &blurred}) plane->resize(rays.width(), rays.height());
  }

  [[nodiscard]] std::size_t at(std::uint32_t u, std::uint32_t v) const {
    return static_cast<std::size_t>(v) * rays.width() + u;
  }
  static Vec3f off_surface(const Hit& hit) { return hit.p_T + (2e-4F + 1e-6F * hit.depth) * hit.face_T; }

  /// Whether any of its rays met something.
  bool trace_block(const ViewOfRows& views, std::uint32_t u0, std::uint32_t v0, const Tile& tile) {
    RayPacket query;
    std::array<Hit, packet> met;
    for (std::uint32_t i = 0; i < packet; ++i) {
      const std::uint32_t u = u0 + i % 4;
      const std::uint32_t v = v0 + i / 4;
      if (u >= tile.u1 || v >= tile.v1 || !rays.is_seen(u, v)) continue;
      const View& view = views.of(v);
      query.set(i, view.camera_T, view.R_TC * rays.centre(u, v), 1e9F);
    }
    scene.trace(query, met);
    RayPacket to_sun;
    bool any = false;
    bool any_hit = false;
    for (std::uint32_t i = 0; i < packet; ++i) {
      if (met[i].material == Hit::nothing) continue;
      any_hit = true;
      const Lighting& light = views.of(v0 + i / 4).light;
      if (light.sunlight <= 0.0F || dot(met[i].face_T, light.sun_T) <= 0.0F) continue;
      // Neighbours ask for opposite edges of the sun, so that they differ wherever there is a penumbra between them.
      constexpr std::array<std::size_t, packet> turns{0, 16, 4, 20, 24, 8, 28, 12};
      to_sun.set(i, off_surface(met[i]), light.sun_T + 0.85F * sun_base_T[2 * turns[i]], 1e9F);
      any = true;
    }
    const std::uint32_t shadowed = any ? scene.blocked(to_sun, true) : 0U;
    Patches::Numbers radiance{};
    if (any_hit) {
      Patches patches{};
      for (std::uint32_t i = 0; i < packet; ++i) {
        if (met[i].material >= Hit::ball) continue;  // balls are drawn apart: marker_lights.hpp
        const bool is_lit = to_sun.is_used[i] != 0 && (shadowed >> i & 1U) == 0U;
        scene.describe(met[i], -Vec3f{query.toward_x[i], query.toward_y[i], query.toward_z[i]}, is_lit ? 1.0F : 0.0F,
                       met[i].depth * rays.pixel_angle(u0 + i % 4, v0 + i / 4), patches, i);
      }
      shade(patches, views.of(v0).light, radiance);
    }
    for (std::uint32_t i = 0; i < packet; ++i) {
      const std::uint32_t u = u0 + i % 4;
      const std::uint32_t v = v0 + i / 4;
      if (u >= tile.u1 || v >= tile.v1) continue;
      const Hit& hit = met[i];
      const std::size_t k = at(u, v);
      Seen& s = seen[k];
      s.material = hit.material;
      s.radiance = behind[k];
      if (hit.material != Hit::nothing) {
        s.triangle = hit.triangle;
        s.depth = hit.depth;
        const bool is_lit = to_sun.is_used[i] != 0 && (shadowed >> i & 1U) == 0U;
        s.radiance = hit.material == Hit::ball ? 0.0F : radiance[i];
        if (to_sun.is_used[i] != 0) s.material |= Seen::faces_sun;
        if (is_lit) s.material |= Seen::lit;
      }
      now.values[k] = s.radiance;
    }
    return any_hit;
  }

  void trace_tile(std::size_t which, const ViewOfRows& views, const Sky& sky) {
    const Tile& tile = tiles[which];
    const bool has_sky = tile.is_seen && sky.may_show(tile.axis_C, tile.half_angle);
    for (std::uint32_t v = tile.v0; v < tile.v1; ++v) {
      for (std::uint32_t u = tile.u0; u < tile.u1; ++u) {
        const std::size_t k = at(u, v);
        behind[k] = has_sky && rays.is_seen(u, v) ? sky.radiance(rays.centre(u, v)) : 0.0F;
      }
    }
    const auto meets = [&](const View& view, const Ball& ball) {
      const Vec3f to_centre_C = to_float(Vec3(view.state.R_CT * to_double(ball.centre_T) + view.state.t_CT));
      const float distance = norm(to_centre_C);
      if (distance <= ball.radius) return true;
      const float angle = std::acos(std::clamp(dot(tile.axis_C, to_centre_C) / distance, -1.0F, 1.0F));
      return angle < tile.half_angle + std::asin(ball.radius / distance);
    };
    const auto meets_any = [&](const View& view) {
      return meets(view, scene.bounds()) && std::any_of(scene.parts().begin(), scene.parts().end(),
                                                        [&](const Ball& part) { return meets(view, part); });
    };
    shows_target[which] = 0;
    if (tile.is_seen && (meets_any(views.of(tile.v0)) || (views.is_rolling() && meets_any(views.of(tile.v1 - 1))))) {
      for (std::uint32_t v = tile.v0; v < tile.v1; v += 2) {
        for (std::uint32_t u = tile.u0; u < tile.u1; u += 4) {
          if (trace_block(views, u, v, tile)) shows_target[which] = 1;
        }
      }
      return;
    }
    for (std::uint32_t v = tile.v0; v < tile.v1; ++v) {
      for (std::uint32_t u = tile.u0; u < tile.u1; ++u) {
        seen[at(u, v)].material = Hit::nothing;
        seen[at(u, v)].radiance = behind[at(u, v)];
        now.values[at(u, v)] = behind[at(u, v)];
      }
    }
  }

  /// It, or a tile beside it: an edge may run along the border between them.
  [[nodiscard]] bool is_near_target(std::size_t which) const {
    const std::size_t across = (rays.width() + tile_width - 1) / tile_width;
    const std::size_t column = which % across;
    return shows_target[which] != 0 || (column > 0 && shows_target[which - 1] != 0) ||
           (column + 1 < across && shows_target[which + 1] != 0) ||
           (which >= across && shows_target[which - across] != 0) ||
           (which + across < tiles.size() && shows_target[which + across] != 0);
  }
  struct Pixel {
    std::uint32_t u;
    std::uint32_t v;
  };
  /// Half a pixel's footprint out of plane, 15 deg, another material, or another light; and to be seen.
  [[nodiscard]] bool differ(Pixel p, Pixel q, const View& view) const {
    const Seen& a = seen[at(p.u, p.v)];
    const Seen& b = seen[at(q.u, q.v)];
    if (std::fabs(a.radiance - b.radiance) <= 0.02F * (a.radiance + b.radiance) + 1e-4F) return false;
    if (a.material != b.material) return true;
    if (a.material == Hit::nothing || a.triangle == b.triangle) return false;
    if ((a.material & ~(Seen::lit | Seen::faces_sun)) == Hit::ball) return false;
    const Vec3f face_T = scene.face_T(a.triangle);
    // Facets of something round are no edges; what of it stands before another part of it is.
    const bool is_smooth = scene.smooth_piece(a.triangle) == scene.smooth_piece(b.triangle);
    if (!is_smooth && std::fabs(dot(face_T, scene.face_T(b.triangle))) < 0.966F) return true;
    const Vec3f between_C = b.depth * rays.centre(q.u, q.v) - a.depth * rays.centre(p.u, p.v);
    return std::fabs(dot(face_T, view.R_TC * between_C)) >
           (is_smooth ? 3.0F : 0.5F) * a.depth * rays.pixel_angle(p.u, p.v);
  }
  [[nodiscard]] bool is_edge(Pixel p, const View& view) const {
    return (p.u > 0 && differ(p, {p.u - 1, p.v}, view)) ||
           (p.u + 1 < rays.width() && differ(p, {p.u + 1, p.v}, view)) ||
           (p.v > 0 && differ(p, {p.u, p.v - 1}, view)) || (p.v + 1 < rays.height() && differ(p, {p.u, p.v + 1}, view));
  }

  /// Whether pixels around that face the sun are all in its light, or all in the shade: no edge of a shadow in between.
  enum class Shadow : std::uint8_t { no, yes, ask };
  [[nodiscard]] Shadow shadow_around(Pixel p) const {
    bool any_lit = false;
    bool any_shadowed = false;
    for (std::uint32_t v = p.v > 0 ? p.v - 1 : 0; v <= std::min(p.v + 1, rays.height() - 1); ++v) {
      for (std::uint32_t u = p.u > 0 ? p.u - 1 : 0; u <= std::min(p.u + 1, rays.width() - 1); ++u) {
        const std::uint32_t material = seen[at(u, v)].material;
        if ((material & Seen::faces_sun) == 0U) continue;
        ((material & Seen::lit) != 0U ? any_lit : any_shadowed) = true;
      }
    }
    if (any_lit == any_shadowed) return Shadow::ask;
    return any_lit ? Shadow::no : Shadow::yes;
  }

  /// A pixel with many rays, while they come in.
  struct Gathering {
    Pixel at;
    const View* view;
    Shadow shadow;
    Vec3f sun_s_T;  // pair across the way to the sun
    Vec3f sun_t_T;
    float missed;
    std::size_t used;
    std::array<Cluster, packet> clusters;

    void add(const Hit& hit, bool is_lit) {
      if (hit.material == Hit::nothing) missed += 1.0F;
      if (hit.material >= Hit::ball) return;  // balls are opaque, and drawn apart
      std::size_t c = 0;
      while (c < used &&
             !(clusters[c].hit.material == hit.material && dot(clusters[c].hit.face_T, hit.face_T) > 0.95F)) {
        ++c;
      }
      c = std::min(c, packet - 1);  // more than eight kinds in a pixel: the last one takes them
      Cluster& cluster = clusters[c];
      if (c == used) {
        ++used;
        cluster = Cluster{hit, 1.0F, 0.0F, 1.0F};
      } else {
        cluster.rays += 1.0F;
        cluster.hit.p_T = cluster.hit.p_T + hit.p_T;
        if (cluster.hit.triangle == hit.triangle) {
          cluster.hit.weight_b += hit.weight_b;
          cluster.hit.weight_c += hit.weight_c;
          cluster.same_triangle += 1.0F;
        }
      }
      cluster.lit += is_lit ? 1.0F : 0.0F;
    }
  };

  /// Pieces of surface that wait for their light, and what of it goes where.
  struct Waiting {
    Patches patches{};
    std::array<std::size_t, Patches::size> pixel;
    std::array<float, Patches::size> share;
    std::size_t count = 0;
    const Lighting* light = nullptr;  // of any of them: from row to row the light hardly changes
  };
  void shade_waiting(Waiting& waiting) {
    if (waiting.count == 0) return;
    Patches::Numbers radiance;
    shade(waiting.patches, *waiting.light, radiance);
    for (std::size_t i = 0; i < waiting.count; ++i) now.values[waiting.pixel[i]] += waiting.share[i] * radiance[i];
    waiting.count = 0;
  }

  /// Pixels with all of `places`; as many of them at a time as fill a packet.
  void supersample(const Pixel* pixels, std::size_t count, const ViewOfRows& views,
                   const std::vector<SamplePlace>& places, Waiting& waiting) {
    const std::size_t rays_each = std::min(places.size(), packet);  // a divisor of packet
    std::array<Gathering, packet / 4> group;
    for (std::size_t g = 0; g < count; ++g) {
      Gathering& p = group[g];
      p.at = pixels[g];
      p.view = &views.of(p.at.v);
      p.shadow = p.view->light.sunlight > 0.0F ? shadow_around(p.at) : Shadow::yes;
      // Each pixel has the sun's disc turned in its own way, or penumbras would show steps.
      const auto turn = static_cast<std::size_t>(hashed(static_cast<std::uint32_t>(at(p.at.u, p.at.v))) % sun_bases);
      p.sun_s_T = sun_base_T[2 * turn];
      p.sun_t_T = sun_base_T[2 * turn + 1];
      p.missed = 0.0F;
      p.used = 0;
    }
    const std::size_t lanes = count * rays_each;
    for (std::size_t first = 0; first < places.size(); first += rays_each) {
      RayPacket query;
      std::array<Hit, packet> met;
      for (std::size_t i = 0; i < lanes; ++i) {
        const Gathering& p = group[i / rays_each];
        const SamplePlace& place = places[first + i % rays_each];
        query.set(i, p.view->camera_T, p.view->R_TC * rays.off_centre(p.at.u, p.at.v, place.du, place.dv), 1e9F);
      }
      scene.trace(query, met);
      std::uint32_t lit = 0;
      bool any = false;
      RayPacket to_sun;
      for (std::size_t i = 0; i < lanes; ++i) {
        const Gathering& p = group[i / rays_each];
        const Vec3f sun_T = p.view->light.sun_T;
        if (p.shadow == Shadow::yes || met[i].material >= Hit::ball || dot(met[i].face_T, sun_T) <= 0.0F) continue;
        lit |= 1U << i;
        if (p.shadow == Shadow::no) continue;
        const SamplePlace& place = places[first + i % rays_each];
        to_sun.set(i, off_surface(met[i]), sun_T + place.sun_s * p.sun_s_T + place.sun_t * p.sun_t_T, 1e9F);
        any = true;
      }
      if (any) lit &= ~scene.blocked(to_sun, true);
      for (std::size_t i = 0; i < lanes; ++i) group[i / rays_each].add(met[i], (lit >> i & 1U) != 0U);
    }
    for (std::size_t g = 0; g < count; ++g) {
      Gathering& p = group[g];
      const std::size_t k = at(p.at.u, p.at.v);
      const float each = 1.0F / static_cast<float>(places.size());
      now.values[k] = each * p.missed * behind[k];
      for (std::size_t c = 0; c < p.used; ++c) {
        Cluster& cluster = p.clusters[c];
        cluster.hit.p_T = (1.0F / cluster.rays) * cluster.hit.p_T;
        cluster.hit.weight_b /= cluster.same_triangle;
        cluster.hit.weight_c /= cluster.same_triangle;
        scene.describe(cluster.hit, normalized(p.view->camera_T - cluster.hit.p_T), cluster.lit / cluster.rays,
                       cluster.hit.depth * rays.pixel_angle(p.at.u, p.at.v), waiting.patches, waiting.count);
        waiting.pixel[waiting.count] = k;
        waiting.share[waiting.count] = each * cluster.rays;
        waiting.light = &p.view->light;
        if (++waiting.count == Patches::size) shade_waiting(waiting);
      }
    }
  }

  void refine_tile(std::size_t which, const ViewOfRows& views, bool all, const std::vector<SamplePlace>& places) {
    if (!is_near_target(which)) return;
    const Tile& tile = tiles[which];
    const std::size_t at_a_time = packet / std::min(places.size(), packet);
    std::array<Pixel, packet> pixels{};
    std::size_t count = 0;
    Waiting waiting;
    for (std::uint32_t v = tile.v0; v < tile.v1; ++v) {
      const View& view = views.of(v);
      for (std::uint32_t u = tile.u0; u < tile.u1; ++u) {
        if (!rays.is_seen(u, v) || !(all || is_edge({u, v}, view))) continue;
        pixels[count++] = {u, v};
        if (count < at_a_time) continue;
        supersample(pixels.data(), count, views, places, waiting);
        count = 0;
      }
    }
    if (count > 0) supersample(pixels.data(), count, views, places, waiting);
    shade_waiting(waiting);
  }

  /// Pixels that the target may fill.
  [[nodiscard]] double area_px(const View& view) const {
    const Ball bounds = scene.bounds();
    const double distance = (view.state.R_CT * to_double(bounds.centre_T) + view.state.t_CT).norm();
    const double radius_px = static_cast<double>(bounds.radius) / std::max(distance, 1e-3) *
                             std::max(camera.intrinsics().fu, camera.intrinsics().fv);
    return std::numbers::pi * radius_px * radius_px;
  }

  void turn_sun_bases(Vec3f sun_T) {
    Vec3f s_T;
    Vec3f t_T;
    base_around(sun_T, s_T, t_T);
    constexpr auto radius = static_cast<float>(sun_radius_rad);
    for (std::size_t i = 0; i < sun_bases; ++i) {
      const float angle = 2.0F * std::numbers::pi_v<float> * static_cast<float>(i) / sun_bases;
      const float c = radius * std::cos(angle);
      const float s = radius * std::sin(angle);
      sun_base_T[2 * i] = c * s_T + s * t_T;
      sun_base_T[2 * i + 1] = c * t_T - s * s_T;
    }
  }

  void draw_instant(const ViewOfRows& views, float weight, bool is_visible_to_stars) {
    const Sky sky(views.middle().state, settings.earth_albedo, settings.earth);
    turn_sun_bases(views.middle().light.sun_T);
    pool.run(tiles.size(), [&](std::size_t which) { trace_tile(which, views, sky); });
    // A small target gets many rays a pixel everywhere: nothing of it is large against a pixel.
    const double area = area_px(views.middle());
    const bool is_small = area < 20'000.0;
    const auto affordable = 8U * static_cast<std::uint32_t>(std::clamp(160'000.0 / (8.0 * area), 1.0, 8.0));
    const std::vector<SamplePlace> places =
        sample_places(is_small ? std::max(settings.edge_samples, affordable) : settings.edge_samples);
    pool.run(tiles.size(), [&](std::size_t which) { refine_tile(which, views, is_small, places); });
    draw_lights(lights, static_cast<float>(settings.light_radiance), views, camera, scene, settings.spread.sigma_px,
                weight, points);
    if (is_visible_to_stars) draw_stars(views.middle(), sky, weight);
  }

  void draw_stars(const View& view, const Sky& sky, float weight) {
    // Irradiance over a pixel's solid angle is radiance; a white surface's is 1 / pi of the sun's irradiance.
    const double unit = std::numbers::pi * camera.intrinsics().fu * camera.intrinsics().fv * settings.star_brightness;
    for (const Star& star : star_catalogue()) {
      const Vec3 toward_C = view.state.R_CI * star.direction_I;
      Vec2 uv_px;
      if (camera.project(toward_C, uv_px) != Status::ok || !camera.in_image(uv_px)) continue;
      const auto u = static_cast<std::uint32_t>(std::lround(std::max(0.0, uv_px.x())));
      const auto v = static_cast<std::uint32_t>(std::lround(std::max(0.0, uv_px.y())));
      if (u >= rays.width() || v >= rays.height()) continue;
      if (seen[at(u, v)].material != Hit::nothing || sky.hides_stars(to_float(toward_C))) continue;
      draw_point(points, uv_px.x(), uv_px.y(), static_cast<double>(weight) * unit * star.irradiance,
                 settings.spread.sigma_px);
    }
  }

  /// How far anything of the target moves while the shutter is open, px.
  [[nodiscard]] double motion_px(const SceneState& begin, const SceneState& end) const {
    double most = 0.0;
    const Ball bounds = scene.bounds();
    for (int i = 0; i < 7; ++i) {
      Vec3 p_T = to_double(bounds.centre_T);
      if (i > 0) p_T((i - 1) / 2) += (i % 2 == 0 ? 1.0 : -1.0) * static_cast<double>(bounds.radius);
      Vec2 a;
      Vec2 b;
      if (camera.project(begin.R_CT * p_T + begin.t_CT, a) == Status::ok &&
          camera.project(end.R_CT * p_T + end.t_CT, b) == Status::ok) {
        most = std::max(most, (a - b).norm());
      }
    }
    return most;
  }

  void render(Time mid, std::uint32_t frame, double exposure_s, double gain,
              const std::function<SceneState(Time)>& state_at, Image& out) {
    const auto after = [&](double share) { return mid + Duration{std::llround(share * exposure_s * 1e9)}; };
    std::uint32_t instants = 1;
    if (settings.motion_blur > 1) {
      const double steps = std::ceil(2.0 * motion_px(state_at(after(-0.5)), state_at(after(0.5))));
      instants = static_cast<std::uint32_t>(std::clamp(steps, 1.0, static_cast<double>(settings.motion_blur)));
    }
    const bool sees_stars = settings.stars && settings.star_brightness > 0.0 &&
                            exposure_s * settings.sensor.electrons_per_s * std::numbers::pi * camera.intrinsics().fu *
                                    camera.intrinsics().fv * settings.star_brightness *
                                    star_catalogue().front().irradiance >
                                1.0;  // electron
    std::fill(points.values.begin(), points.values.end(), 0.0F);
    const float weight = 1.0F / static_cast<float>(instants);
    for (std::uint32_t i = 0; i < instants; ++i) {
      const ViewOfRows views(after((i + 0.5) / instants - 0.5), settings.row_time_us * 1e-6, rays.height(),
                             {settings.earth_albedo, settings.fill}, state_at);
      draw_instant(views, weight, sees_stars);
      if (instants == 1) {
        std::swap(now.values, sharp.values);
      } else {
        if (i == 0) std::fill(sharp.values.begin(), sharp.values.end(), 0.0F);
        for (std::size_t k = 0; k < sharp.values.size(); ++k) sharp.values[k] += weight * now.values[k];
      }
    }
    spread.apply(sharp, points, pool, blurred);
    sensor.expose(blurred, exposure_s, gain, frame, pool, out);
  }
};

SceneRenderer::SceneRenderer(const RenderSettings& settings, const CameraModel& camera, const TargetModel* lights,
                             std::uint64_t seed)
    : SceneRenderer(settings, camera, lights, seed,
                    settings.mesh.empty() ? make_satellite(lights) : load_mesh(settings.mesh, settings.placement)) {}

SceneRenderer::SceneRenderer(const RenderSettings& settings, const CameraModel& camera, const TargetModel* lights,
                             std::uint64_t seed, Mesh mesh)
    : state_(std::make_unique<State>(settings, camera, lights, seed, std::move(mesh))) {}

SceneRenderer::~SceneRenderer() = default;

bool SceneRenderer::is_inside(const SceneState& state) const {
  return state_->scene.encloses(to_float(Vec3(-(state.R_CT.transpose() * state.t_CT))));
}

void SceneRenderer::render(Time mid_exposure, std::uint32_t frame, double exposure_s, double gain,
                           const std::function<SceneState(Time)>& state_at, Image& out) {
  state_->render(mid_exposure, frame, exposure_s, gain, state_at, out);
}

}  // namespace relnav::hil
