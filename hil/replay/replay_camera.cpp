#include "hil/replay/replay_camera.hpp"

#include <algorithm>
#include <chrono>
#include <thread>

#include "platform/files/input_error.hpp"

namespace relnav::hil {

ReplayCamera::ReplayCamera(std::vector<ImageEntry> entries, std::uint32_t width_px, std::uint32_t height_px,
                           hal::Clock& clock, Pace pace, Depth depth)
    : entries_(std::move(entries)),
      width_px_(width_px),
      height_px_(height_px),
      clock_(clock),
      pace_(pace),
      depth_(depth) {}

Status ReplayCamera::start() {
  streaming_ = true;
  return Status::ok;
}

Status ReplayCamera::stop() {
  streaming_ = false;
  return Status::ok;
}

std::size_t ReplayCamera::frames_done() const {
  const auto out = std::count_if(slots_.begin(), slots_.end(), [](const Slot& s) { return s.lease != 0; });
  return next_ - static_cast<std::size_t>(out);
}

Status ReplayCamera::await_due(Duration wait) {
  if (pace_ == Pace::max) return Status::ok;
  const Time now = clock_.now();
  if (!paced_) {
    paced_ = true;
    first_handed_out_ = now;
    first_stamp_ = entries_[next_].time;
  }
  const Duration early{(entries_[next_].time - first_stamp_).ns - (now - first_handed_out_).ns};
  if (early.ns <= 0) return Status::ok;
  std::this_thread::sleep_for(std::chrono::nanoseconds(std::min(early.ns, std::max<std::int64_t>(wait.ns, 0))));
  if (early <= wait) return Status::ok;
  return wait.ns > 0 ? Status::timeout : Status::no_data;
}

Status ReplayCamera::acquire(Duration wait, hal::Frame& frame) {
  if (!streaming_) return Status::not_configured;
  const auto slot = std::find_if(slots_.begin(), slots_.end(), [](const Slot& s) { return s.lease == 0; });
  if (slot == slots_.end()) return Status::no_capacity;
  if (exhausted()) return Status::no_data;
  const Status due = await_due(wait);
  if (due != Status::ok) return due;

  const ImageEntry& entry = entries_[next_++];
  try {
    slot->image = load_image(entry);
    if (slot->image.width_px != width_px_ || slot->image.height_px != height_px_) {
      throw InputError(place_text(entry), 0,
                       std::to_string(slot->image.width_px) + " x " + std::to_string(slot->image.height_px) + " pixels",
                       std::to_string(width_px_) + " x " + std::to_string(height_px_) + " as the camera file says");
    }
  } catch (const std::exception& error) {
    if (problem_.empty()) problem_ = error.what();
    ++incomplete_;
    return Status::incomplete;
  }
  if (depth_ == Depth::eight_bits) keep_upper_bytes(slot->image);
  slot->lease = ++last_lease_;
  frame = {};
  frame.pixels = slot->image.bytes.data();
  frame.width_px = width_px_;
  frame.height_px = height_px_;
  frame.stride_bytes = slot->image.bytes_per_pixel * width_px_;
  frame.format = slot->image.bytes_per_pixel == 2 ? hal::PixelFormat::mono16 : hal::PixelFormat::mono8;
  frame.mid_exposure = frame.first_data = frame.dequeued = entry.time;
  frame.clock = hal::ClockId::device;
  frame.sequence = static_cast<std::uint32_t>(next_ - 1);
  frame.lease = slot->lease;
  return Status::ok;
}

Status ReplayCamera::release(const hal::Frame& frame) {
  if (frame.lease == 0) return Status::stale_handle;
  const auto slot = std::find_if(slots_.begin(), slots_.end(), [&](const Slot& s) { return s.lease == frame.lease; });
  if (slot == slots_.end()) return Status::stale_handle;
  slot->lease = 0;
  return Status::ok;
}

}  // namespace relnav::hil
