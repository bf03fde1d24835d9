#include "fsw/app/frame_mate.hpp"

namespace relnav::app {

Status FrameMate::give_back() {
  if (!has_waiting_) return Status::ok;
  has_waiting_ = false;
  return camera_->release(waiting_);
}

Status FrameMate::start() {
  const Status released = give_back();
  const Status started = camera_->start();
  return started != Status::ok ? started : released;
}

Status FrameMate::stop() {
  const Status released = give_back();
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
    if (late_ns >= -tolerance.ns) {
      has_waiting_ = false;
      frame = waiting_;
      return Status::ok;
    }
    const Status released = give_back();
    if (released != Status::ok) return released;
  }
  return Status::timeout;
}

}  // namespace relnav::app
