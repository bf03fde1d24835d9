#pragma once
#include <cstdint>
#include <functional>
#include <memory>

#include "fsw/base/time.hpp"
#include "fsw/geometry/camera_model.hpp"
#include "fsw/geometry/target_model.hpp"
#include "hil/io/image.hpp"
#include "hil/render/mesh.hpp"
#include "hil/render/render_settings.hpp"
#include "hil/simulation/scene_state.hpp"

namespace relnav::hil {

/// Images of the target as the camera sees it. Rays go through the flight code's camera model, so that its projection and
/// distortion hold exactly; pixels that the model does not reach stay black. The same seed, frame and scene give the same
/// bytes, on any number of threads (on one build and machine).
class SceneRenderer {
 public:
  /// `lights`: luminous balls of the markers (satellite.hpp has their radius); null: none. `seed`: of the sensor.
  /// Throws InputError when the mesh or one of its images cannot be used, std::invalid_argument without a camera.
  SceneRenderer(const RenderSettings& settings, const CameraModel& camera, const TargetModel* lights,
                std::uint64_t seed);
  /// A mesh of the caller's, instead of what settings.mesh says.
  SceneRenderer(const RenderSettings& settings, const CameraModel& camera, const TargetModel* lights,
                std::uint64_t seed, Mesh mesh);
  ~SceneRenderer();
  SceneRenderer(const SceneRenderer&) = delete;
  SceneRenderer& operator=(const SceneRenderer&) = delete;

  /// The camera is inside of the mesh.
  [[nodiscard]] bool is_inside(const SceneState& state) const;

  /// `state_at`: truth, asked within the exposure of every row. `mid_exposure`: of the row in the middle, with a rolling
  /// shutter. `frame`: makes this frame's noise. `exposure_s`, `gain`: as the flight code set them (hal/exposure_control.hpp).
  void render(Time mid_exposure, std::uint32_t frame, double exposure_s, double gain,
              const std::function<SceneState(Time)>& state_at, Image& out);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace relnav::hil
