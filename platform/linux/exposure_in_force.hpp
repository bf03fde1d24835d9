#pragma once
#include "fsw/base/time.hpp"
#include "platform/linux/camera_driver.hpp"

namespace relnav::platform::linux {

/// With what a frame was exposed, where a driver only knows when it told the camera: what began to be exposed before that still
/// has the exposure of before.
class ExposureInForce {
 public:
  struct Values {
    Duration exposure;  ///< 0: not known
    double gain = 0.0;  ///< 0: not known
  };

  /// Of a stream that begins.
  void restart(const Values& values) { before_ = latest_ = values; }
  /// The camera took these at `time`.
  void change(Time time, const Values& values) {
    before_ = latest_;
    latest_ = values;
    changed_ = time;
  }
  /// Of a frame by its stamp, on the clock of change().
  [[nodiscard]] const Values& at(Time stamp, StampMeaning meaning) const {
    Time begin = stamp;
    if (meaning == StampMeaning::mid_exposure) begin.ns -= before_.exposure.ns / 2;
    if (meaning == StampMeaning::end_of_exposure) begin.ns -= before_.exposure.ns;
    return begin < changed_ ? before_ : latest_;
  }

 private:
  Values before_;
  Values latest_;
  Time changed_;
};

}  // namespace relnav::platform::linux
