#pragma once
#include <functional>
#include <vector>

#include "hil/render/lighting.hpp"
#include "hil/simulation/scene_state.hpp"

namespace relnav::hil {

/// The scene at the instant in which a row is exposed, as its rays need it.
struct View {
  SceneState state;
  Mat3f R_TC;
  Vec3f camera_T;
  Lighting light;
};

struct LightLevels {
  double earth_albedo = 0.3;
  double fill = 0.0;
};
[[nodiscard]] View make_view(const SceneState& state, const LightLevels& levels);

/// One view for all rows, or with a rolling shutter one for each.
class ViewOfRows {
 public:
  /// `mid`: of the row in the middle. Between nine instants all goes linearly: what a target turns meanwhile is small.
  ViewOfRows(Time mid, double row_time_s, std::uint32_t rows, const LightLevels& levels,
             const std::function<SceneState(Time)>& state_at);

  [[nodiscard]] const View& of(std::uint32_t row) const { return views_[views_.size() == 1 ? 0 : row]; }
  [[nodiscard]] const View& middle() const { return views_[views_.size() / 2]; }
  [[nodiscard]] bool is_rolling() const { return views_.size() > 1; }

 private:
  std::vector<View> views_;
};

}  // namespace relnav::hil
