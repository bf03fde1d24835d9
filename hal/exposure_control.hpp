#pragma once
#include "fsw/base/status.hpp"
#include "fsw/base/time.hpp"

namespace relnav::hal {

/// How long a camera exposes, and how much its signal is amplified.
struct Exposure {
  Duration time;
  double gain = 1.0;  ///< levels of pixels are proportional to time and gain, as well as the camera keeps to that
  /// Without == of numbers, which clang takes for a mistake (-Wfloat-equal).
  friend bool operator==(const Exposure& a, const Exposure& b) {
    return a.time == b.time && a.gain <= b.gain && a.gain >= b.gain;
  }
};

/// Both ends belong to it.
struct ExposureLimits {
  Duration time_min;
  Duration time_max;
  double gain_min = 1.0;
  double gain_max = 1.0;  ///< equal: the gain is fixed
};

/// Sets a camera's exposure while it streams. Contract (tests/contract/exposure_control_contract.hpp):
/// EXP-1  While the camera is not started limits() and set() return not_configured, after its loss device_lost.
/// EXP-2  limits() on ok: 0 < time_min <= time_max, 0 < gain_min <= gain_max < infinity; the same until the camera is started anew.
/// EXP-3  set() outside the limits, or of what is no number, returns invalid_argument.
/// EXP-4  set() on ok: `applied` is what the camera makes of it (its nearest step), within the limits. Setting that again gives
///        the same.
/// EXP-5  A later frame is the first exposed so; it has applied.time in Frame::exposure, at the latest the third frame whose
///        exposure began after set(). No frame says so whose exposure ended before set().
/// EXP-6  On any status but ok limits, `applied` and what was applied before are unchanged; the next call stands on its own.
/// EXP-7  A camera that was lost and is started anew exposes as was applied last.
/// EXP-8  Neither call waits for a frame.
class ExposureControl {
 public:
  virtual Status limits(ExposureLimits& limits) = 0;
  virtual Status set(const Exposure& wanted, Exposure& applied) = 0;

 protected:
  ExposureControl() = default;
  ExposureControl(const ExposureControl&) = default;
  ExposureControl& operator=(const ExposureControl&) = default;
  ~ExposureControl() = default;
};

}  // namespace relnav::hal
