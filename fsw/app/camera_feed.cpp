#include "fsw/app/camera_feed.hpp"

#include "fsw/app/camera_image.hpp"
#include "fsw/app/saturating.hpp"

namespace relnav::app {

void CameraFeed::configure(const FrameLimits& limits, Duration longest_silence, std::uint32_t width_px,
                           std::uint32_t height_px, int sensor_bits) {
  checks_.configure(limits, width_px, height_px, sensor_bits);
  longest_silence_ = longest_silence;
  measures_ = false;
  sensor_bits_ = sensor_bits;
  is_lost_ = false;
  attempts_ = 0;
  silence_ = {};
  outcome_ = FeedOutcome();
  counts_ = Counts();
}

void CameraFeed::measure_brightness(const vision::BrightnessSettings& settings) {
  measures_ = true;
  brightness_ = settings;
}

Status CameraFeed::start() {
  const Status status = camera_->start();
  is_lost_ = status != Status::ok;
  silence_ = {};
  return status;
}

Status CameraFeed::stop() {
  const Status released = has_lease_ ? camera_->release(frame_) : Status::ok;
  has_frame_ = has_lease_ = false;  // whatever the camera says: it starts anew
  const Status stopped = camera_->stop();
  return stopped != Status::ok ? stopped : released;
}

Status CameraFeed::give_back() {
  has_frame_ = false;
  const Status released = camera_->release(frame_);
  has_lease_ = released != Status::ok && released != Status::stale_handle;
  // A lease that cannot be given back would starve the camera: it is started anew.
  if (released != Status::ok) lose(released);
  return released;
}

void CameraFeed::fetch(Duration wait, Duration already_waited) {
  fetch_time_ = {};
  if (has_frame_) return;
  if (is_lost_ && !recover()) {
    outcome_.status = outcome_.reason = Status::device_lost;
    return;
  }
  silence_.ns += already_waited.ns;
  hal::Frame frame;
  const Time begin = clock_.now();
  const Status acquired = camera_->acquire(wait, frame);
  fetch_time_ = clock_.now() - begin;
  if (acquired == Status::ok) {
    take(frame);
  } else {
    without_frame(acquired, wait);
  }
}

void CameraFeed::take(const hal::Frame& frame) {
  silence_ = {};
  frame_ = frame;
  has_frame_ = has_lease_ = true;
  const FrameCheck check = checks_.check(frame, clock_.now(), clock_.id());
  counts_.missing = saturated_sum(counts_.missing, check.missing_by_sequence);
  outcome_.received = true;
  outcome_.frame = frame;
  outcome_.check = check;
  outcome_.status = outcome_.reason = status_of(check.fault);
  outcome_.refused = check.fault != FrameFault::none;
  // A frozen image would be corrected for ever, one of another time twice.
  outcome_.measured = measures_ && (check.fault == FrameFault::none || check.fault == FrameFault::no_contrast);
  if (outcome_.measured) outcome_.brightness = brightness_of(frame);
  if (!outcome_.refused) return;
  increment(counts_.refused);
  static_cast<void>(give_back());  // lost if it fails
}

vision::Brightness CameraFeed::brightness_of(const hal::Frame& frame) const {
  const CameraImage image = image_of(frame);
  if (const auto* deep = std::get_if<vision::ImageView16>(&image)) {
    return vision::measure_brightness(*deep, sensor_bits_, brightness_);
  }
  const auto* shallow = std::get_if<vision::ImageView>(&image);
  return shallow == nullptr ? vision::Brightness() : vision::measure_brightness(*shallow, 8, brightness_);
}

void CameraFeed::without_frame(Status reason, Duration wait) {
  outcome_.status = outcome_.reason = reason;
  switch (reason) {
    case Status::no_data: break;
    case Status::timeout: silence_.ns += wait.ns; break;
    case Status::device_lost:
    case Status::not_configured:
    case Status::no_capacity: lose(reason); break;
    default: outcome_.status = Status::incomplete; return;
  }
  if (silence_ >= longest_silence_) lose(Status::timeout);
  if (is_lost_) outcome_.status = Status::device_lost;
}

void CameraFeed::lose(Status reason) {
  if (is_lost_) return;
  is_lost_ = true;
  attempts_ = 0;
  increment(counts_.losses);
  outcome_.lost_for = reason;
}

bool CameraFeed::recover() {
  increment(attempts_);
  const Status stopped = stop();  // a camera that only fell silent still streams
  if (start() != Status::ok) return false;
  outcome_.attempts = attempts_;
  outcome_.stop_answer = stopped;
  return true;
}

}  // namespace relnav::app
