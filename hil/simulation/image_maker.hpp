#pragma once
#include <functional>
#include <memory>

#include "hal/exposure_control.hpp"
#include "hil/io/image.hpp"
#include "hil/simulation/scenario_file.hpp"
#include "hil/simulation/scene_state.hpp"

namespace relnav::hil {

/// Makes what one camera sees.
class ImageMaker {
 public:
  virtual ~ImageMaker() = default;
  /// The camera is inside of the target.
  [[nodiscard]] virtual bool is_inside(const SceneState& state) const = 0;
  /// `mid`: the scene at mid-exposure, in this camera's frame. `frame`: its number, part of the noise's seed.
  virtual void make(const SceneState& mid, std::uint32_t frame, const hal::Exposure& exposure, Image& image) = 0;

 protected:
  ImageMaker() = default;
  ImageMaker(const ImageMaker&) = default;
  ImageMaker& operator=(const ImageMaker&) = default;
};

/// One for a camera of the scenario. Throws InputError.
using ImageMakerFactory =
    std::function<std::unique_ptr<ImageMaker>(const SimulationScenario&, const CameraModel&, std::uint64_t seed)>;

}  // namespace relnav::hil
