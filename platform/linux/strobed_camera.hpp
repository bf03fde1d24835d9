#pragma once
#include <cstdint>

#include "hal/camera.hpp"
#include "hal/gpio_lines.hpp"

namespace relnav::platform::linux {

/// Another camera, whose strobe or trigger line is raised before it is waited for, and lowered when the frame is there or the
/// wait has run out. The line is an output that has been requested, low. A line that cannot be driven does not keep frames
/// away; it is counted, and line_status() says why. Lines whose chip was lost are requested again every 64th failure.
class StrobedCamera final : public hal::Camera {
 public:
  StrobedCamera(hal::Camera& camera, hal::GpioLines& lines, std::uint32_t offset)
      : camera_(camera), lines_(lines), offset_(offset) {}

  Status start() override {
    const Status status = camera_.start();
    streaming_ = status == Status::ok;
    return status;
  }

  Status acquire(Duration wait, hal::Frame& frame) override {
    // No light for a frame that could not be taken anyway: a triggered camera would expose it and lose it.
    if (!streaming_ || leases_ >= camera_.max_leases()) return camera_.acquire(wait, frame);
    drive(true);
    const Status status = camera_.acquire(wait, frame);
    drive(false);
    if (status == Status::ok) ++leases_;
    if (status == Status::device_lost) streaming_ = false;
    return status;
  }

  Status release(const hal::Frame& frame) override {
    const Status status = camera_.release(frame);
    if (status == Status::ok) --leases_;
    return status;
  }

  Status stop() override {
    streaming_ = false;
    return camera_.stop();
  }

  [[nodiscard]] std::uint32_t max_leases() const override { return camera_.max_leases(); }

  /// How often the line could not be driven, and the latest reason.
  [[nodiscard]] std::uint64_t line_failures() const { return line_failures_; }
  [[nodiscard]] Status line_status() const { return line_status_; }

 private:
  static constexpr std::uint64_t failures_between_requests = 64;  // looking for a chip takes longer than a frame should

  void drive(bool level) {
    const Status status = lines_.set(offset_, level);
    if (status == Status::ok) return;
    line_status_ = status;
    ++line_failures_;
    if (status != Status::device_lost || line_failures_ % failures_between_requests != 0) return;
    static_cast<void>(lines_.release(offset_));  // whichever fails, set() will say so
    static_cast<void>(lines_.request_output(offset_, false));
  }

  hal::Camera& camera_;
  hal::GpioLines& lines_;
  std::uint32_t offset_;
  std::uint32_t leases_ = 0;
  bool streaming_ = false;
  Status line_status_ = Status::ok;
  std::uint64_t line_failures_ = 0;
};

}  // namespace relnav::platform::linux
