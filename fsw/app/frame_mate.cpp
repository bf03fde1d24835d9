#include "fsw/app/frame_mate.hpp"

namespace relnav::app {

Status FrameMate::start() {
  has_waiting_ = false;
  return camera_->start();
}

Status FrameMate::stop() {
  const Status released = has_waiting_ ? camera_->release(waiting_) : Status::ok;
  has_waiting_ = false;
  const Status stopped = camera_->stop();
  return released != Status::ok ? released : stopped;
}

Status FrameMate::acquire(Time time, Duration tolerance, Duration wait, hal::Frame& frame) {
  for (int k = 0; k < most_dropped; ++k) {
    if (!has_waiting_) {
      const Status status = camera_->acquire(wait, waiting_);
      if (status != Status::ok) return status;
      has_waiting_ = true;
    }
    const std::int64_t late_ns = (waiting_.mid_exposure - time).ns;
    if (late_ns > tolerance.ns) return Status::timeout;
    has_waiting_ = false;
    if (late_ns >= -tolerance.ns) {
      frame = waiting_;
      return Status::ok;
    }
    const Status released = camera_->release(waiting_);
    if (released != Status::ok) return released;
  }
  return Status::timeout;
}

}  // namespace relnav::app
