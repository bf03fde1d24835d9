#pragma once
#include <cstdint>

#include "hal/exposure_control.hpp"
#include "platform/linux/stream_camera.hpp"

namespace relnav::platform::linux {

/// What the numbers of a camera's gain mean.
struct GainUnit {
  enum class Kind : std::uint8_t { linear, decibel };
  Kind kind = Kind::linear;
  double step = 1.0;  ///< factors, or decibels, in one unit of the driver
};

/// Exposure of a StreamCamera. hal::Exposure::gain is the factor that the driver's number stands for; a linear gain of 0 is not
/// offered. Where the camera has no gain to set it is 1.
class StreamExposure final : public hal::ExposureControl {
 public:
  /// `camera` outlives it.
  StreamExposure(StreamCamera& camera, GainUnit unit) : camera_(camera), unit_(unit) {}

  Status limits(hal::ExposureLimits& limits) override;
  Status set(const hal::Exposure& wanted, hal::Exposure& applied) override;

 private:
  [[nodiscard]] double factor_of(double gain) const;
  [[nodiscard]] double gain_of(double factor) const;

  StreamCamera& camera_;
  GainUnit unit_;
};

}  // namespace relnav::platform::linux
