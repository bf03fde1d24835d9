#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "hal/camera.hpp"
#include "platform/host/bounded_record.hpp"
#include "platform/host/scripted_clock.hpp"

namespace relnav::platform::host {

/// A call the camera has seen, with its answer.
struct CameraCall {
  enum class Kind : std::uint8_t { start, acquire, release, stop };
  Kind kind = Kind::start;
  Status answer = Status::ok;
  Duration wait{};             ///< acquire
  std::uint32_t sequence = 0;  ///< acquire (ok) and release
  std::uint32_t lease = 0;     ///< acquire (ok) and release
};

/// Camera that answers by script: frames, statuses and delays, in the order pushed. Pixels stay the test's: keep them alive until
/// the frame is released. What the script says is handed out as it is (a bad sequence, stamp or size is a fault to be played);
/// leases, start, stop and loss of the device follow the contract. No allocation after construction.
class ScriptedCamera final : public hal::Camera {
 public:
  explicit ScriptedCamera(std::uint32_t max_leases = 2, std::size_t script_capacity = 4096);

  // Script. no_capacity when it is full.
  /// `lease` of the frame is set when it is handed out.
  Status push_frame(const hal::Frame& frame);
  /// Frame of 8-bit pixels without gaps between rows, with all three stamps equal.
  Status push_frame(std::span<const std::uint8_t> pixels, std::uint32_t width_px, std::uint32_t height_px,
                    Time mid_exposure, std::uint32_t sequence);
  /// The next acquire() answers `status` (not ok). device_lost also ends streaming until start().
  Status push_status(Status status);
  /// What follows comes this much later: an acquire() with a shorter wait times out and uses up its part of the delay.
  Status push_delay(Duration delay);
  /// The next `count` calls of start() answer `status`.
  void fail_starts(Status status, std::uint32_t count = 1);
  /// The next `count` calls of release() answer `status` and keep the lease.
  void fail_releases(Status status, std::uint32_t count = 1);
  /// stop() answers `status` from now on (and still stops).
  void set_stop_answer(Status status) { stop_answer_ = status; }
  /// Time spent waiting is added to this clock.
  void attach_clock(ScriptedClock& clock) { clock_ = &clock; }

  // What happened.
  [[nodiscard]] const BoundedRecord<CameraCall>& calls() const { return calls_; }
  [[nodiscard]] std::uint32_t leases_out() const { return leases_out_; }
  [[nodiscard]] std::uint32_t frames_handed_out() const { return frames_handed_out_; }
  [[nodiscard]] bool streaming() const { return streaming_; }
  [[nodiscard]] std::size_t script_left() const { return script_.pending(); }

  Status start() override;
  Status acquire(Duration wait, hal::Frame& frame) override;
  Status release(const hal::Frame& frame) override;
  Status stop() override;
  [[nodiscard]] std::uint32_t max_leases() const override { return static_cast<std::uint32_t>(leases_.size()); }

 private:
  struct Item {
    enum class Kind : std::uint8_t { frame, status, delay };
    Kind kind = Kind::frame;
    hal::Frame frame;
    Status status = Status::ok;
    Duration delay;
  };
  struct Failure {
    Status status = Status::ok;
    std::uint32_t count = 0;
  };

  Status push(const Item& item);
  Status next_answer(Duration wait, hal::Frame& frame);
  void wait_for(Duration length);
  static bool take_failure(Failure& failure);

  BoundedRecord<Item> script_;
  BoundedRecord<CameraCall> calls_;
  std::vector<std::uint32_t> leases_;  ///< a number for each lease that is out, 0 for the rest
  std::uint32_t leases_out_ = 0;
  std::uint32_t last_lease_ = 0;
  std::uint32_t frames_handed_out_ = 0;
  bool streaming_ = false;
  bool lost_ = false;
  Failure start_failure_;
  Failure release_failure_;
  Status stop_answer_ = Status::ok;
  ScriptedClock* clock_ = nullptr;
};

}  // namespace relnav::platform::host
