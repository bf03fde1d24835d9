#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

#include "fsw/estimation/scalar_traits.hpp"
#include "fsw/estimation/stereo_closed_form.hpp"
#include "fsw/geometry/motor.hpp"
#include "fsw/geometry/triangulation.hpp"

namespace relnav {

/// triangulate_features() in any scalar: p_T over `model_unit`, p_C over `range_unit` (m).
template <typename S>
Status triangulate_features(const CameraRig& rig, const TargetModel& target, const PoseObservations& observations,
                            double model_unit, double range_unit, StereoPointsIn<S>& points) {
  constexpr std::size_t absent = config::max_observations;
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
  const Eigen::Matrix<S, 3, 3> R_KC = rig[1].R_KC.template cast<S>();
  const Eigen::Matrix<S, 3, 1> t_KC = Vec3(rig[1].t_KC / range_unit).template cast<S>();
  std::size_t apart = 0;
  for (std::size_t f = 0; f < target.features.size(); ++f) {
    std::array<Vec2, 2> xy;
    std::array<std::uint16_t, 2> of_camera;
    bool in_both = true;
    for (std::size_t k = 0; k < 2; ++k) {
      in_both = in_both && seen[k][f] != absent;
      if (!in_both) break;
      of_camera[k] = static_cast<std::uint16_t>(seen[k][f]);
      const Status status = normalised_image(rig[k], observations[of_camera[k]].uv_px, xy[k]);
      if (status != Status::ok) return status;
    }
    if (!in_both) continue;
    Eigen::Matrix<S, 3, 1> p_C;
    const Status status = triangulate<S>(xy[0].template cast<S>(), xy[1].template cast<S>(), R_KC, t_KC, p_C);
    if (status != Status::ok && status != Status::rank_deficient) return status;
    if (status == Status::rank_deficient || !is_sound(p_C) || !(p_C(2) > S(0))) {
      ++apart;
      continue;
    }
    // As many points as features at most: there is room.
    RELNAV_ASSERT(points.feature.push_back(static_cast<std::uint16_t>(f)) == Status::ok);
    RELNAV_ASSERT(points.observation.push_back(of_camera) == Status::ok);
    RELNAV_ASSERT(points.p_T.push_back(Vec3(target.features[f].p_T / model_unit).template cast<S>()) == Status::ok);
    RELNAV_ASSERT(points.p_C.push_back(p_C) == Status::ok);
  }
  return apart > points.p_C.size() ? Status::inconsistent : Status::ok;
}

/// Corresponding lines, one by one: use(a, b) with positions in `points`.
template <typename S, typename Use>
void for_each_line(const TargetModel& target, const StereoPointsIn<S>& points, MotorLines lines, const Use& use) {
  const std::size_t n = points.feature.size();
  if (lines == MotorLines::target && !target.lines.empty()) {
    const auto position_of = [&](std::uint16_t feature) {
      std::size_t i = 0;
      while (i < n && points.feature[i] != feature) ++i;  // bound: n, the points
      return i;
    };
    for (const TargetLine& line : target.lines) {
      const std::size_t a = position_of(line.from);
      const std::size_t b = position_of(line.to);
      if (a < n && b < n) use(a, b);
    }
    return;
  }
  for (std::size_t a = 0; a + 1 < n; ++a) {
    const std::size_t end = lines == MotorLines::all ? n : a + 2;
    for (std::size_t b = a + 1; b < end; ++b) use(a, b);
  }
}

/// solve_motor() in any scalar. Points of both frames are in one unit; p_C about any origin, t_CT from there.
template <typename S>
Status solve_motor(const TargetModel& target, const StereoPointsIn<S>& points, MotorLines lines,
                   Eigen::Matrix<S, 3, 3>& R_CT, Eigen::Matrix<S, 3, 1>& t_CT) {
  constexpr std::size_t least_points = 3;
  using Line = MotorLine<S>;
  if (points.p_T.size() < least_points) return Status::too_few_features;
  // The rotor needs directions, the translator the moments afterwards.
  std::size_t count = 0;
  for_each_line(target, points, lines, [&](std::size_t, std::size_t) { ++count; });
  RotorEquations<S> rotor(count);
  for_each_line(target, points, lines, [&](std::size_t a, std::size_t b) {
    rotor.add(Line::through(points.p_T[a], points.p_T[b]).n, Line::through(points.p_C[a], points.p_C[b]).n);
  });
  Status status = rotor.solve(S(ScalarTraits<S>::least_gap), R_CT);
  if (status != Status::ok) return status;
  TranslatorEquations<S> translator(count);
  for_each_line(target, points, lines, [&](std::size_t a, std::size_t b) {
    translator.add(Line::through(points.p_C[a], points.p_C[b]), R_CT * Line::through(points.p_T[a], points.p_T[b]).m);
  });
  return translator.solve(S(ScalarTraits<S>::least_pivot), t_CT);
}

}  // namespace relnav
