#include "platform/host/scripted_camera.hpp"

#include <algorithm>

namespace relnav::platform::host {

ScriptedCamera::ScriptedCamera(std::uint32_t max_leases, std::size_t script_capacity)
    : script_(script_capacity), calls_(4 * script_capacity), leases_(max_leases, 0U) {}

Status ScriptedCamera::push(const Item& item) { return script_.push(item) ? Status::ok : Status::no_capacity; }

Status ScriptedCamera::push_frame(const hal::Frame& frame) {
  Item item;
  item.frame = frame;
  return push(item);
}

Status ScriptedCamera::push_frame(std::span<const std::uint8_t> pixels, std::uint32_t width_px, std::uint32_t height_px,
                                  Time mid_exposure, std::uint32_t sequence) {
  if (pixels.size() != std::size_t{width_px} * height_px) return Status::invalid_argument;
  hal::Frame frame;
  frame.pixels = pixels.data();
  frame.width_px = width_px;
  frame.height_px = height_px;
  frame.stride_bytes = width_px;
  frame.mid_exposure = mid_exposure;
  frame.first_data = mid_exposure;
  frame.dequeued = mid_exposure;
  frame.sequence = sequence;
  return push_frame(frame);
}

Status ScriptedCamera::push_status(Status status) {
  if (status == Status::ok) return Status::invalid_argument;
  Item item;
  item.kind = Item::Kind::status;
  item.status = status;
  return push(item);
}

Status ScriptedCamera::push_delay(Duration delay) {
  if (delay.ns < 0) return Status::invalid_argument;
  Item item;
  item.kind = Item::Kind::delay;
  item.delay = delay;
  return push(item);
}

void ScriptedCamera::fail_starts(Status status, std::uint32_t count) { start_failure_ = {status, count}; }
void ScriptedCamera::fail_releases(Status status, std::uint32_t count) { release_failure_ = {status, count}; }

bool ScriptedCamera::take_failure(Failure& failure) {
  if (failure.count == 0) return false;
  --failure.count;
  return true;
}

Status ScriptedCamera::start() {
  Status answer = Status::ok;
  if (take_failure(start_failure_)) {
    answer = start_failure_.status;
  } else {
    streaming_ = true;
    lost_ = false;
  }
  calls_.push({.kind = CameraCall::Kind::start, .answer = answer});
  return answer;
}

Status ScriptedCamera::acquire(Duration wait, hal::Frame& frame) {
  const Status answer = next_answer(wait, frame);
  CameraCall call{.kind = CameraCall::Kind::acquire, .answer = answer, .wait = wait};
  if (answer == Status::ok) {
    call.sequence = frame.sequence;
    call.lease = frame.lease;
  }
  calls_.push(call);
  return answer;
}

Status ScriptedCamera::next_answer(Duration wait, hal::Frame& frame) {
  if (lost_) return Status::device_lost;
  if (!streaming_) return Status::not_configured;
  const auto free_lease = std::find(leases_.begin(), leases_.end(), 0U);
  if (free_lease == leases_.end()) return Status::no_capacity;

  Duration left{std::max<std::int64_t>(wait.ns, 0)};
  while (script_.has_next()) {
    Item& item = script_.next();
    if (item.kind == Item::Kind::delay) {
      const Duration waited{std::min(item.delay.ns, left.ns)};
      wait_for(waited);
      item.delay.ns -= waited.ns;
      left.ns -= waited.ns;
      if (item.delay.ns > 0) return wait.ns > 0 ? Status::timeout : Status::no_data;
      script_.skip();
      continue;
    }
    if (item.kind == Item::Kind::status) {
      const Status status = item.status;
      script_.skip();
      if (status == Status::device_lost) {
        lost_ = true;
        streaming_ = false;
      }
      return status;
    }
    frame = item.frame;
    script_.skip();
    ++last_lease_;
    if (last_lease_ == 0) ++last_lease_;  // 0 means free
    *free_lease = last_lease_;
    frame.lease = last_lease_;
    ++leases_out_;
    ++frames_handed_out_;
    return Status::ok;
  }
  wait_for(left);
  return wait.ns > 0 ? Status::timeout : Status::no_data;
}

void ScriptedCamera::wait_for(Duration length) {
  if (clock_ != nullptr) clock_->advance(length);
}

Status ScriptedCamera::release(const hal::Frame& frame) {
  Status answer = Status::ok;
  const auto lease = std::find(leases_.begin(), leases_.end(), frame.lease);
  if (frame.lease == 0 || lease == leases_.end()) {
    answer = Status::stale_handle;
  } else if (take_failure(release_failure_)) {
    answer = release_failure_.status;
  } else {
    *lease = 0;
    --leases_out_;
  }
  calls_.push({.kind = CameraCall::Kind::release, .answer = answer, .sequence = frame.sequence, .lease = frame.lease});
  return answer;
}

Status ScriptedCamera::stop() {
  streaming_ = false;
  calls_.push({.kind = CameraCall::Kind::stop, .answer = stop_answer_});
  return stop_answer_;
}

}  // namespace relnav::platform::host
