#include "hil/render/scene_image_maker.hpp"

#include "hil/render/scene_renderer.hpp"
#include "hil/simulation/scene_motion.hpp"

namespace relnav::hil {
namespace {

RenderSettings settings_of(const SimulationScenario& scenario) {
  if (!scenario.render.IsDefined() || scenario.render.IsNull()) return {};
  return read_render_settings(FileSection(scenario.path, scenario.render, "render", render_keys()));
}

class SceneImageMaker final : public ImageMaker {
 public:
  SceneImageMaker(const SimulationScenario& scenario, const CameraModel& camera, std::uint64_t seed)
      : renderer_(settings_of(scenario), camera, scenario.target.features.empty() ? nullptr : &scenario.target, seed) {}

  [[nodiscard]] bool is_inside(const SceneState& state) const override { return renderer_.is_inside(state); }
  void make(const SceneState& mid, std::uint32_t frame, const hal::Exposure& exposure, Image& image) override {
    renderer_.render(
        mid.time, frame, exposure.time.seconds(), exposure.gain, [&](Time time) { return moved_on(mid, time); }, image);
  }

 private:
  SceneRenderer renderer_;
};

}  // namespace

std::unique_ptr<ImageMaker> make_scene_image_maker(const SimulationScenario& scenario, const CameraModel& camera,
                                                   std::uint64_t seed) {
  return std::make_unique<SceneImageMaker>(scenario, camera, seed);
}

}  // namespace relnav::hil
