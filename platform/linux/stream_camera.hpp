#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "hal/camera.hpp"
#include "hal/clock.hpp"
#include "platform/linux/camera_driver.hpp"
#include "platform/linux/device_clock.hpp"

namespace relnav::platform::linux {

enum class FramePolicy : std::uint8_t {
  newest,       ///< older frames that wait go back unseen and are counted: an image is never older than it must be
  every_frame,  ///< for recording
};

struct StreamOptions {
  std::uint32_t leases = 3;
  FramePolicy policy = FramePolicy::newest;
  /// Every image is copied and its buffer given back at once: for sources that overwrite buffers on loan (v4l2loopback does).
  bool always_copy = false;
  /// Free running, or asked for by software: so long without a frame, and the driver counts as lost. At least 3 periods of
  /// CameraSettings::rate_hz, whatever stands here. 0: never.
  Duration frame_timeout{1'000'000'000};
  /// The same, for the first frame after opening.
  Duration first_frame_timeout{3'000'000'000};
  /// Between attempts to open, doubled from the first to the second while they fail. After a loss in mid-stream the first
  /// attempt comes at once.
  Duration shortest_retry{50'000'000};
  Duration longest_retry{400'000'000};
  std::int64_t max_clock_drift_ppm = 100;  ///< see DeviceClock
};

/// Since construction.
struct StreamCounts {
  std::uint64_t delivered = 0;   ///< handed out
  std::uint64_t skipped = 0;     ///< good, but a newer one was there
  std::uint64_t incomplete = 0;  ///< damaged, never handed out
  std::uint64_t underruns = 0;   ///< lost for want of a buffer, as far as the driver knows
  std::uint64_t losses = 0;      ///< of the device, while streaming
  std::uint64_t reconnects = 0;  ///< opened again after a loss
  std::uint64_t attempts = 0;    ///< to open, successful or not
};

/// hal::Camera on any CameraDriver: closed -> streaming -> lost -> streaming ..., the same for all kinds of cameras. Every
/// attempt to leave `lost` is a complete close() and open() of the driver, with all settings.
///
/// Beyond the contract of hal::Camera:
/// - start() while an attempt is not due yet returns at once with the answer of the one before. no_capacity: leases of the
///   former stream are still out; their pixels lie in the driver's memory, so it stays open until they are given back.
/// - acquire() takes anything a driver cannot explain (io_error, another size, a lost buffer) for a loss of the device.
/// - Sequence numbers keep increasing over the camera's whole life. A driver that counts anew, or not at all, is counted here.
/// - Frame::clock is monotonic. With CameraSettings::original_stamps it is device: mid_exposure is the driver's stamp as it is
///   (which has to mean mid-exposure then), and first_data and dequeued are equal to it.
/// - With Trigger::software acquire() asks for a frame, unless one is on its way.
/// - No heap after construction but for the text of problems.
/// Not thread-safe. `driver` and `clock` (CLOCK_MONOTONIC) outlive it, its leases do not.
class StreamCamera final : public hal::Camera {
 public:
  StreamCamera(CameraDriver& driver, hal::Clock& clock, CameraSettings settings, StreamOptions options = {});
  ~StreamCamera();
  StreamCamera(const StreamCamera&) = delete;
  StreamCamera& operator=(const StreamCamera&) = delete;

  Status start() override;
  Status acquire(Duration wait, hal::Frame& frame) override;
  Status release(const hal::Frame& frame) override;
  Status stop() override;
  [[nodiscard]] std::uint32_t max_leases() const override { return static_cast<std::uint32_t>(leases_.size()); }

  /// Of the camera while it streams, with no exposure longer than a period of CameraSettings::rate_hz. not_configured,
  /// device_lost; unsupported: it has no exposure time to set.
  Status exposure_range(ExposureRange& range);
  /// See CameraDriver::adjust. What was taken replaces exposure and gain of the settings, and is pushed with each later start.
  Status adjust(ExposureValues& values);

  [[nodiscard]] bool is_streaming() const { return state_ == State::streaming; }
  [[nodiscard]] StreamCounts counts() const;
  /// Latest error, one line: device, what is wrong, what was expected. Empty: none yet.
  [[nodiscard]] const std::string& problem() const { return problem_; }
  /// Until the next attempt of start() is due; 0: now. What a caller with nothing else to do may sleep.
  [[nodiscard]] Duration until_next_attempt() const;
  /// Of the frame handed out latest; 0: not known.
  [[nodiscard]] double gain() const { return gain_; }

 private:
  enum class State : std::uint8_t { closed, streaming, lost };
  struct Lease {
    std::uint32_t name = 0;  ///< 0: free
    bool on_loan = false;    ///< its pixels are the driver's buffer
    std::uint32_t buffer = 0;
  };
  /// A good image that acquire() has in hand.
  struct Candidate {
    bool exists = false;
    bool on_loan = false;  ///< else it has been copied
    RawImage image;
    std::uint64_t number = 0;
  };
  [[nodiscard]] Status state_status() const;
  enum class Taken : std::uint8_t { good, damaged, nothing, failed };

  [[nodiscard]] Status check_settings();
  void plan_next_attempt();
  Status lose(const std::string& problem);
  void close_driver_if_unused();

  [[nodiscard]] Lease* free_lease();
  [[nodiscard]] std::span<std::uint8_t> memory_of(const Lease& lease);
  Status ask_for_frame();
  /// What acquire() answers without a frame: a silence that lasts too long is a loss.
  Status without_frame(Status status);
  /// `lease`: the free one whose memory may be used.
  Taken take_one(Duration wait, const Lease& lease, Candidate& candidate);
  /// All of these: false is a fault of the driver, and problem_ says which.
  [[nodiscard]] bool settle(Candidate& candidate);
  [[nodiscard]] bool copy(Candidate& candidate, const Lease& lease);
  [[nodiscard]] bool hand_out(Candidate& candidate, Lease& lease, hal::Frame& frame);
  [[nodiscard]] bool give_back(std::uint32_t buffer);
  [[nodiscard]] std::uint64_t number_of(const RawImage& image);
  void stamp(const RawImage& image, hal::Frame& frame);

  CameraDriver& driver_;
  hal::Clock& clock_;
  CameraSettings settings_;
  StreamOptions options_;
  Duration frame_timeout_;
  DeviceClock device_clock_;

  State state_ = State::closed;
  bool has_range_ = false;  ///< since open()
  ExposureRange range_;
  bool driver_is_open_ = false;  ///< also while closed or lost, until the last loan is back
  std::vector<Lease> leases_;
  std::vector<std::uint8_t> memory_;  ///< a mono image for each lease
  std::uint32_t last_lease_ = 0;
  std::uint32_t loans_ = 0;  ///< the driver's buffers that are out

  Time last_sign_;           ///< latest frame, or begin of waiting for the first one
  bool has_frames_ = false;  ///< since open()
  bool asked_ = false;       ///< by trigger(), and not answered yet
  Time asked_at_;

  std::uint64_t next_number_ = 0;    ///< least that the next frame may have
  std::uint64_t sequence_base_ = 0;  ///< number = base + driver's sequence
  std::uint32_t failures_ = 0;       ///< attempts in a row without a frame
  Time next_attempt_;
  Status attempt_status_ = Status::not_configured;
  bool was_lost_ = false;  ///< and not opened since

  StreamCounts counts_;
  std::uint64_t former_underruns_ = 0;
  double gain_ = 0.0;
  std::string problem_;
};

}  // namespace relnav::platform::linux
