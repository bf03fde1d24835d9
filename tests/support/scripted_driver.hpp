#pragma once
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "platform/host/scripted_clock.hpp"
#include "platform/linux/camera_driver.hpp"
#include "platform/linux/pixel_conversion.hpp"

namespace relnav::test {

/// CameraDriver that plays what a test offers, and keeps book of buffers. Its buffers exist from open() to close(), each a block
/// of its own, so that a sanitizer sees who uses one too long. Waiting uses up the clock's time.
class ScriptedDriver final : public platform::linux::CameraDriver {
 public:
  /// What comes next. `image.bytes`, buffer and dequeued are filled in by take(); first_data as well where it is 0.
  struct Shot {
    platform::linux::RawImage image;
    std::uint8_t fill = 0;        ///< of every byte
    std::size_t bytes_short = 0;  ///< the buffer ends so much too early
    Status status = Status::ok;   ///< else take() answers this
  };

  explicit ScriptedDriver(platform::host::ScriptedClock& clock) : clock_(clock) {}

  // The world.
  bool present = true;
  Status open_answer = Status::no_data;  ///< of open() while not present
  std::uint32_t loans_allowed = 6;
  Status give_back_answer = Status::ok;
  Status trigger_answer = Status::ok;
  std::uint64_t underruns_seen = 0;
  platform::linux::RawFormat format = platform::linux::RawFormat::grey8;
  std::uint32_t padding_bytes = 0;  ///< at the end of each row
  bool counts = true;               ///< has_sequence
  Duration open_takes;
  platform::linux::ExposureRange range{100.0, 50'000.0, true, 0.0, 40.0};
  Status range_answer = Status::ok;
  Status adjust_answer = Status::ok;
  double exposure_step_us = 100.0;

  /// A good frame of the size and format set, stamped now.
  Shot shot() {
    Shot shot;
    shot.image.width_px = settings_.width_px;
    shot.image.height_px = settings_.height_px;
    shot.image.format = format;
    shot.image.stride_bytes =
        static_cast<std::uint32_t>(platform::linux::row_bytes(format, settings_.width_px)) + padding_bytes;
    shot.image.complete = true;
    shot.image.stamp = clock_.peek();
    shot.image.stamp_meaning = platform::linux::StampMeaning::mid_exposure;
    shot.image.exposure.ns = static_cast<std::int64_t>(settings_.exposure_us * 1e3);
    shot.image.gain = settings_.gain;
    shot.image.has_sequence = counts;
    shot.image.sequence = counts ? sequence_ : 0;
    shot.fill = static_cast<std::uint8_t>(fills_++);
    ++sequence_;
    return shot;
  }
  void offer(Shot shot) { waiting_.push_back(std::move(shot)); }
  void offer_good() { offer(shot()); }
  void offer_damaged() {
    Shot damaged = shot();
    damaged.image.complete = false;
    offer(damaged);
  }
  void offer_status(Status status) {
    Shot failure;
    failure.status = status;
    offer(failure);
  }
  /// Frames that the source sends and nobody gets.
  void skip_sequence(std::uint32_t frames) { sequence_ += frames; }
  void restart_sequence() { sequence_ = 0; }

  // What happened.
  std::vector<platform::linux::CameraSettings> opened_with;  ///< one a call of open()
  std::vector<Time> opened_at;
  std::size_t closes = 0;
  std::size_t triggers = 0;
  std::vector<platform::linux::ExposureValues> adjusted_to;  ///< one a call of adjust()
  std::size_t most_loans = 0;
  std::size_t mistakes = 0;  ///< of the user: too many loans, buffers given back twice, calls while closed
  [[nodiscard]] bool is_open() const { return is_open_; }
  [[nodiscard]] std::size_t loans() const { return buffers_.size(); }
  [[nodiscard]] std::size_t waiting() const { return waiting_.size(); }
  /// `pixels` lie in a buffer on loan.
  [[nodiscard]] bool lends(const std::uint8_t* pixels) const {
    return std::any_of(buffers_.begin(), buffers_.end(), [&](const Buffer& b) { return b.bytes.get() == pixels; });
  }

  Status open(const platform::linux::CameraSettings& settings) override {
    if (is_open_) ++mistakes;
    opened_with.push_back(settings);
    opened_at.push_back(clock_.peek());
    clock_.advance(open_takes);
    settings_ = settings;
    if (!present) {
      problem_ = settings.device + ": not there";
      return open_answer;
    }
    is_open_ = true;
    sequence_ = 0;
    waiting_.clear();
    return Status::ok;
  }
  void close() override {
    if (!is_open_) ++mistakes;
    is_open_ = false;
    ++closes;
    buffers_.clear();
  }
  Status take(Duration wait, platform::linux::RawImage& image) override {
    if (!is_open_) ++mistakes;
    if (!present) {
      problem_ = settings_.device + ": gone";
      return Status::device_lost;
    }
    if (waiting_.empty()) {
      clock_.advance(wait);
      return wait.ns > 0 ? Status::timeout : Status::no_data;
    }
    const Shot next = waiting_.front();
    waiting_.pop_front();
    if (next.status != Status::ok) {
      problem_ = settings_.device + ": " + to_string(next.status);
      return next.status;
    }
    if (buffers_.size() >= loans_allowed) ++mistakes;
    Buffer buffer;
    buffer.name = next_buffer_++;
    const std::size_t size =
        static_cast<std::size_t>(next.image.stride_bytes) * next.image.height_px - next.bytes_short;
    buffer.bytes = std::make_unique<std::uint8_t[]>(size);
    std::fill_n(buffer.bytes.get(), size, next.fill);
    image = next.image;
    image.bytes = {buffer.bytes.get(), size};
    image.buffer = buffer.name;
    image.dequeued = clock_.peek();
    if (image.first_data.ns == 0) image.first_data = image.dequeued;
    buffers_.push_back(std::move(buffer));
    most_loans = std::max(most_loans, buffers_.size());
    return Status::ok;
  }
  Status give_back(std::uint32_t buffer) override {
    const auto found =
        std::find_if(buffers_.begin(), buffers_.end(), [&](const Buffer& b) { return b.name == buffer; });
    if (!is_open_ || found == buffers_.end()) {
      ++mistakes;
      return Status::stale_handle;
    }
    buffers_.erase(found);
    if (give_back_answer != Status::ok) problem_ = settings_.device + ": took no buffer back";
    return give_back_answer;
  }
  Status trigger() override {
    if (!is_open_) ++mistakes;
    ++triggers;
    if (trigger_answer != Status::ok) problem_ = settings_.device + ": no trigger";
    return trigger_answer;
  }
  Status exposure_range(platform::linux::ExposureRange& out) override {
    if (!is_open_) ++mistakes;
    if (range_answer != Status::ok) problem_ = settings_.device + ": no exposure";
    if (range_answer == Status::ok) out = range;
    return range_answer;
  }
  Status adjust(platform::linux::ExposureValues& values) override {
    if (!is_open_) ++mistakes;
    adjusted_to.push_back(values);
    if (adjust_answer != Status::ok) {
      problem_ = settings_.device + ": exposure not taken";
      return adjust_answer;
    }
    values.exposure_us = std::max(1.0, std::round(values.exposure_us / exposure_step_us)) * exposure_step_us;
    values.gain = std::round(values.gain);
    settings_.exposure_us = values.exposure_us;
    settings_.gain = values.gain;
    return Status::ok;
  }
  [[nodiscard]] std::uint32_t max_loans() const override { return loans_allowed; }
  [[nodiscard]] std::uint64_t underruns() const override { return underruns_seen; }
  [[nodiscard]] const std::string& problem() const override { return problem_; }

 private:
  struct Buffer {
    std::uint32_t name = 0;
    std::unique_ptr<std::uint8_t[]> bytes;
  };

  platform::host::ScriptedClock& clock_;
  platform::linux::CameraSettings settings_;
  bool is_open_ = false;
  std::deque<Shot> waiting_;
  std::vector<Buffer> buffers_;  ///< on loan
  std::uint32_t next_buffer_ = 0;
  std::uint32_t sequence_ = 0;
  std::uint32_t fills_ = 1;
  std::string problem_;
};

}  // namespace relnav::test
