#include "fsw/estimation/stereo_closed_form.hpp"

#include <array>

#include "fsw/geometry/motor.hpp"
#include "fsw/geometry/triangulation.hpp"

namespace relnav {
namespace {

constexpr std::size_t least_points = 3;
constexpr double least_pivot = 1e-13;
/// Mean over the lines of 1 - cos(angle between directions), about, under which they count as parallel.
constexpr double least_gap = 1e-9;
/// Of the angle at A in a triple (A, B, C), under which three points count as lying on a line.
constexpr double least_sine = 1e-6;
constexpr std::size_t absent = config::max_observations;

/// Normalised, undistorted.
Status image_of(const RigCamera& camera, const Vec2& uv_px, Vec2& xy) {
  Vec3 ray_C;
  const Status status = camera.model.unproject(uv_px, ray_C);
  if (status != Status::ok) return status;
  if (!(ray_C.z() > 0.0)) return Status::outside_domain;
  xy = ray_C.head<2>() / ray_C.z();
  return Status::ok;
}

std::size_t position_of(const StereoPoints& points, std::uint16_t feature) {
  for (std::size_t i = 0; i < points.feature.size(); ++i) {
    if (points.feature[i] == feature) return i;
  }
  return absent;
}

using Line = MotorLine<double>;

/// Corresponding lines, one by one: the rotor needs directions, the translator the moments afterwards.
template <typename Use>
void for_each_line(const TargetModel& target, const StereoPoints& points, MotorLines lines, const Use& use) {
  const std::size_t n = points.p_T.size();
  if (lines == MotorLines::target && !target.lines.empty()) {
    for (const TargetLine& line : target.lines) {
      const std::size_t a = position_of(points, line.from);
      const std::size_t b = position_of(points, line.to);
      if (a != absent && b != absent) use(a, b);
    }
    return;
  }
  for (std::size_t a = 0; a + 1 < n; ++a) {
    const std::size_t end = lines == MotorLines::all ? n : a + 2;
    for (std::size_t b = a + 1; b < end; ++b) use(a, b);
  }
}

}  // namespace

Status triangulate_pixels(const CameraRig& rig, const Vec2& uv_0_px, const Vec2& uv_1_px, Vec3& p_C) {
  Vec2 xy_0;
  Vec2 xy_1;
  Status status = image_of(rig[0], uv_0_px, xy_0);
  if (status == Status::ok) status = image_of(rig[1], uv_1_px, xy_1);
  if (status == Status::ok) status = triangulate<double>(xy_0, xy_1, rig[1].R_KC, rig[1].t_KC, least_pivot, p_C);
  if (status != Status::ok) return status;
  return p_C.z() > 0.0 ? Status::ok : Status::behind_camera;
}

Status triangulate_features(const CameraRig& rig, const TargetModel& target, const PoseObservations& observations,
                            StereoPoints& points) {
  if (rig.size() != 2) return Status::invalid_argument;
  std::array<std::array<std::size_t, config::max_target_features>, 2> seen;
  for (auto& of_camera : seen) of_camera.fill(absent);
  for (std::size_t i = 0; i < observations.size(); ++i) {
    const PoseObservation& o = observations[i];
    if (o.camera >= rig.size() || o.feature >= target.features.size()) return Status::invalid_argument;
    seen[o.camera][o.feature] = i;
  }
  points.feature.clear();
  points.observation.clear();
  points.p_T.clear();
  points.p_C.clear();
  std::size_t apart = 0;
  for (std::size_t f = 0; f < target.features.size(); ++f) {
    if (seen[0][f] == absent || seen[1][f] == absent) continue;
    const std::size_t o_0 = seen[0][f];
    const std::size_t o_1 = seen[1][f];
    Vec3 p_C;
    const Status status = triangulate_pixels(rig, observations[o_0].uv_px, observations[o_1].uv_px, p_C);
    if (status == Status::rank_deficient || status == Status::behind_camera) {
      ++apart;
      continue;
    }
    if (status != Status::ok) return status;
    // As many points as features at most: there is room.
    RELNAV_ASSERT(points.feature.push_back(static_cast<std::uint16_t>(f)) == Status::ok);
    RELNAV_ASSERT(points.observation.push_back({static_cast<std::uint16_t>(o_0), static_cast<std::uint16_t>(o_1)}) ==
                  Status::ok);
    RELNAV_ASSERT(points.p_T.push_back(target.features[f].p_T) == Status::ok);
    RELNAV_ASSERT(points.p_C.push_back(p_C) == Status::ok);
  }
  return apart > points.p_C.size() ? Status::inconsistent : Status::ok;
}

Status solve_motor(const TargetModel& target, const StereoPoints& points, MotorLines lines, Pose& out) {
  if (points.p_T.size() < least_points) return Status::too_few_features;
  RotorEquations<double> rotor;
  for_each_line(target, points, lines, [&](std::size_t a, std::size_t b) {
    rotor.add(Line::through(points.p_T[a], points.p_T[b]).n, Line::through(points.p_C[a], points.p_C[b]).n);
  });
  Status status = rotor.solve(least_gap, out.R_CT);
  if (status != Status::ok) return status;
  TranslatorEquations<double> translator;
  for_each_line(target, points, lines, [&](std::size_t a, std::size_t b) {
    translator.add(Line::through(points.p_C[a], points.p_C[b]),
                   out.R_CT * Line::through(points.p_T[a], points.p_T[b]).m);
  });
  return translator.solve(least_pivot, out.t_CT);
}

Status solve_orthogonal(const StereoPoints& points, Pose& out) {
  const std::size_t n = points.p_T.size();
  if (n < least_points) return Status::too_few_features;
  RotorEquations<double> rotation;
  out.t_CT.setZero();
  for (std::size_t i = 0; i < n; ++i) {
    const auto triad = [&](const auto& p, std::array<Vec3, 3>& axes) {
      axes[0] = p[(i + 1) % n] - p[i];
      axes[1] = p[(i + 2) % n] - p[i];
      axes[0].normalize();
      axes[1].normalize();
      axes[2] = Line::cross(axes[0], axes[1]);
      // On a line there is no normal, only rounding errors: leave them as small as they are.
      if (axes[2].norm() > least_sine) axes[2].normalize();
    };
    std::array<Vec3, 3> axes_T;
    std::array<Vec3, 3> axes_C;
    triad(points.p_T, axes_T);
    triad(points.p_C, axes_C);
    for (std::size_t k = 0; k < 3; ++k) rotation.add(axes_T[k], axes_C[k]);
    out.t_CT += points.p_C[i] / static_cast<double>(n);
  }
  return rotation.solve(least_gap, out.R_CT);
}

}  // namespace relnav
