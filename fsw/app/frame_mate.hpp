#pragma once
#include "fsw/base/time.hpp"
#include "hal/camera.hpp"

namespace relnav::app {

/// Finds the second camera's frame that belongs to one of the first. A frame that came too early for it waits, on its lease.
class FrameMate {
 public:
  explicit FrameMate(hal::Camera* camera) : camera_(camera) {}

  [[nodiscard]] bool exists() const { return camera_ != nullptr; }
  /// Also of a camera that streams or has been lost: a frame that waits is given back first.
  Status start();
  Status stop();
  /// The next frame is here already.
  [[nodiscard]] bool is_waiting() const { return has_waiting_; }
  /// Older frames are dropped. timeout: the next frame is later than `time`; it is kept. Else the camera's own errors.
  Status acquire(Time time, Duration tolerance, Duration wait, hal::Frame& frame);
  Status release(const hal::Frame& frame) { return camera_->release(frame); }

 private:
  static constexpr int most_dropped = 16;  ///< in one call

  Status give_back();

  hal::Camera* camera_;
  hal::Frame waiting_;
  bool has_waiting_ = false;
};

}  // namespace relnav::app
