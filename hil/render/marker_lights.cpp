#include "hil/render/marker_lights.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "hil/render/satellite.hpp"

namespace relnav::hil {
namespace {

struct DiscPoint {
  double x;  // in radii
  double y;
  double share;  // of the area
};

/// Rings of equal width, each with an even number of points: the centroid is the centre.
std::vector<DiscPoint> disc_points(int rings) {
  std::vector<DiscPoint> points;
  for (int k = 0; k < rings; ++k) {
    const int n = 6 * k + 4;
    const double area = (2.0 * k + 1.0) / (rings * rings);
    // All points of a ring at the radius that gives it its true second moment.
    const double radius = std::sqrt((k * k + (k + 1.0) * (k + 1.0)) / 2.0) / rings;
    for (int i = 0; i < n; ++i) {
      const double angle = 2.0 * std::numbers::pi * (i + 0.5 * (k % 2)) / n;
      points.push_back({radius * std::cos(angle), radius * std::sin(angle), area / n});
    }
  }
  return points;
}

/// The view of the row in which a point of T is seen, and where.
struct Sighting {
  const View* view;
  Vec2 uv_px;
};
std::optional<Sighting> sighted(const Vec3& p_T, const ViewOfRows& views, const CameraModel& camera) {
  Sighting s{&views.middle(), Vec2::Zero()};
  const double last = camera.intrinsics().height_px - 1;
  const int rounds =
      views.is_rolling() ? 3 : 1;  // each is closer by the share of a row in which the target moves a row
  for (int i = 0; i < rounds; ++i) {
    if (i > 0) s.view = &views.of(static_cast<std::uint32_t>(std::lround(std::clamp(s.uv_px.y(), 0.0, last))));
    if (camera.project(s.view->state.R_CT * p_T + s.view->state.t_CT, s.uv_px) != Status::ok) return std::nullopt;
  }
  return s;
}

}  // namespace

void draw_lights(const TargetModel& lights, float radiance, const ViewOfRows& views, const CameraModel& camera,
                 const MeshScene& scene, double sigma_px, float weight, Plane& points) {
  const double focal_px = std::max(camera.intrinsics().fu, camera.intrinsics().fv);
  for (const TargetFeature& light : lights.features) {
    const auto centre = sighted(light.p_T, views, camera);
    if (!centre || !camera.in_image(centre->uv_px, -60.0)) continue;
    const Vec3 camera_T = to_double(centre->view->camera_T);
    const Vec3 back = light.p_T - camera_T;
    const double distance = back.norm();
    if (distance <= 2.0 * light_radius) continue;
    double facing = 1.0;
    if (light.normal_T.squaredNorm() > 0.0) facing = std::clamp(-5.0 * light.normal_T.dot(back) / distance, 0.0, 1.0);
    if (facing <= 0.0) continue;

    // The circle in which the line of sight touches the ball.
    const double ratio = light_radius / distance;
    const Vec3 circle_T = light.p_T - ratio * ratio * back;
    const double radius = light_radius * std::sqrt(1.0 - ratio * ratio);
    Vec3f s_T;
    Vec3f t_T;
    base_around(to_float(Vec3(back / distance)), s_T, t_T);
    const auto on_circle = [&](double x, double y) {
      return Vec3(circle_T + radius * (x * to_double(s_T) + y * to_double(t_T)));
    };

    // Its area in the image.
    constexpr int corners = 24;
    std::vector<Vec2> outline;
    for (int i = 0; i < corners; ++i) {
      const double angle = 2.0 * std::numbers::pi * i / corners;
      if (const auto at = sighted(on_circle(std::cos(angle), std::sin(angle)), views, camera)) {
        outline.push_back(at->uv_px);
      }
    }
    if (outline.size() != corners) continue;
    double area = 0.0;
    for (std::size_t i = 0; i < corners; ++i) {
      const Vec2& p = outline[i];
      const Vec2& q = outline[(i + 1) % corners];
      area += 0.5 * (p.x() * q.y() - p.y() * q.x());
    }
    constexpr double inscribed = corners / (2.0 * std::numbers::pi);
    area = std::fabs(area) / (inscribed * std::sin(2.0 * std::numbers::pi / corners));

    const int rings = std::clamp(static_cast<int>(std::ceil(focal_px * ratio / 0.5)), 1, 14);
    const std::vector<DiscPoint> disc = disc_points(rings);
    for (std::size_t first = 0; first < disc.size(); first += RayPacket::size) {
      const std::size_t n = std::min(RayPacket::size, disc.size() - first);
      RayPacket rays;
      for (std::size_t i = 0; i < n; ++i) {
        const Vec3f to_point_T = to_float(Vec3(on_circle(disc[first + i].x, disc[first + i].y) - camera_T));
        rays.set(i, centre->view->camera_T, to_point_T, static_cast<float>(1.0 - 1.05 * ratio));
      }
      const std::uint32_t hidden = scene.blocked(rays, true);
      for (std::size_t i = 0; i < n; ++i) {
        const DiscPoint& p = disc[first + i];
        if ((hidden >> i & 1U) != 0U) continue;
        const auto at = sighted(on_circle(p.x, p.y), views, camera);
        if (!at) continue;
        draw_point(points, at->uv_px.x(), at->uv_px.y(),
                   static_cast<double>(weight * radiance) * facing * area * p.share, sigma_px);
      }
    }
  }
}

}  // namespace relnav::hil
