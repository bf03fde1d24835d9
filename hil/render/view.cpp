#include "hil/render/view.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "hil/render/sky.hpp"

namespace relnav::hil {
namespace {

SceneState between(const SceneState& a, const SceneState& b, double t) {
  SceneState s = a;
  s.time = a.time + Duration{std::llround(t * static_cast<double>((b.time - a.time).ns))};
  s.t_CT = a.t_CT + t * (b.t_CT - a.t_CT);
  s.R_CT = a.R_CT + t * (b.R_CT - a.R_CT);
  s.R_CI = a.R_CI + t * (b.R_CI - a.R_CI);
  s.sun_C = (a.sun_C + t * (b.sun_C - a.sun_C)).normalized();
  s.sunlight = a.sunlight + t * (b.sunlight - a.sunlight);
  s.earth_C = a.earth_C + t * (b.earth_C - a.earth_C);
  return s;
}

}  // namespace

View make_view(const SceneState& state, const LightLevels& levels) {
  View view;
  view.state = state;
  const Mat3 R_TC = state.R_CT.transpose();
  view.R_TC = to_float(R_TC);
  view.camera_T = to_float(Vec3(-(R_TC * state.t_CT)));
  Lighting& light = view.light;
  light.sun_T = to_float(Vec3(R_TC * state.sun_C));
  light.sunlight = static_cast<float>(state.sunlight);
  light.fill = static_cast<float>(levels.fill);
  if (const double distance = state.earth_C.norm(); distance > 0.0) {
    light.earth_T = to_float(Vec3(R_TC * state.earth_C / distance));
    const double sine = std::min(0.9999, earth_radius / distance);
    light.earth_sin = static_cast<float>(sine);
    light.earth_cos = static_cast<float>(std::sqrt(1.0 - sine * sine));
    light.earth_radiance = static_cast<float>(mean_earth_radiance(state, levels.earth_albedo));
  }
  return view;
}

ViewOfRows::ViewOfRows(Time mid, double row_time_s, std::uint32_t rows, const LightLevels& levels,
                       const std::function<SceneState(Time)>& state_at) {
  if (row_time_s <= 0.0 || rows < 2) {
    views_.push_back(make_view(state_at(mid), levels));
    return;
  }
  constexpr std::size_t instants = 9;
  const double middle = 0.5 * (rows - 1);
  std::array<SceneState, instants> states;
  for (std::size_t k = 0; k < instants; ++k) {
    const double row = (rows - 1) * static_cast<double>(k) / (instants - 1);
    states[k] = state_at(mid + Duration{std::llround((row - middle) * row_time_s * 1e9)});
  }
  for (std::uint32_t row = 0; row < rows; ++row) {
    const double at = static_cast<double>(row) / (rows - 1) * (instants - 1);
    const auto k = std::min<std::size_t>(instants - 2, static_cast<std::size_t>(at));
    views_.push_back(make_view(between(states[k], states[k + 1], at - static_cast<double>(k)), levels));
  }
}

}  // namespace relnav::hil
