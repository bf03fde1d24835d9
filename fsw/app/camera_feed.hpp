#pragma once
#include <cstdint>

#include "fsw/app/frame_checks.hpp"
#include "fsw/vision/brightness.hpp"
#include "hal/camera.hpp"
#include "hal/clock.hpp"

namespace relnav::app {

/// What one camera did in a step.
struct FeedOutcome {
  /// ok: a frame to be used; no_data, timeout: none came; incomplete: a damaged one, or the camera's own error; device_lost;
  /// else what the frame was refused for, as status_of() says.
  Status status = Status::no_data;
  Status reason = Status::no_data;  ///< the camera's own words for it
  Status lost_for = Status::ok;     ///< not ok: lost in this step, and why
  std::uint32_t attempts = 0;       ///< not 0: works again, at this attempt
  Status stop_answer = Status::ok;  ///< of the camera, before it was started anew
  bool received = false;            ///< `frame` came in this step; its lease may be over
  bool refused = false;             ///< and must not be used
  hal::Frame frame;
  FrameCheck check;       ///< of that frame
  bool measured = false;  ///< `brightness` is of that frame, used or not: black and white ones have to be seen as well
  vision::Brightness brightness;

  [[nodiscard]] bool damaged() const { return status == Status::incomplete && !refused; }
  [[nodiscard]] bool waited_in_vain() const { return reason == Status::timeout && !refused; }
};

/// One camera of the flight loop: has its frames checked, holds the lease of one at a time, counts what goes wrong. A camera that
/// is lost, silent for too long or keeps a lease is stopped and started anew, once in a step.
class CameraFeed {
 public:
  struct Counts {
    std::uint32_t refused = 0;
    std::uint32_t missing = 0;  ///< by sequence number
    std::uint16_t losses = 0;
  };

  CameraFeed(hal::Camera* camera, hal::Clock& clock) : camera_(camera), clock_(clock) {}

  [[nodiscard]] bool exists() const { return camera_ != nullptr; }
  /// Forgets all frames and counts. For a camera that does not stream. `sensor_bits` as FrameChecks::configure.
  void configure(const FrameLimits& limits, Duration longest_silence, std::uint32_t width_px, std::uint32_t height_px,
                 int sensor_bits);
  /// Has the brightness of frames measured from now on, until configure().
  void measure_brightness(const vision::BrightnessSettings& settings);
  Status start();
  /// A lease that is still held is given back first; nothing of the frames is kept.
  Status stop();

  /// A new step: the outcome of the one before is forgotten.
  void begin_step() { outcome_ = FeedOutcome(); }
  /// Unless a frame is held already: asks for one, after a new start if need be. `already_waited`: of this step, for the other
  /// camera and without a frame from this one either; it counts as silence.
  void fetch(Duration wait, Duration already_waited = {});
  /// Of a frame that is held. Not ok: the camera keeps the lease and counts as lost.
  Status give_back();
  /// See FrameChecks.
  void accept_new_time_base() { checks_.accept_new_time_base(); }

  [[nodiscard]] bool has_frame() const { return has_frame_; }
  [[nodiscard]] const hal::Frame& frame() const { return frame_; }
  [[nodiscard]] bool is_lost() const { return is_lost_; }
  /// Waited in vain since the last frame or start, by the length of the waits asked for.
  [[nodiscard]] Duration silence() const { return silence_; }
  [[nodiscard]] const FeedOutcome& outcome() const { return outcome_; }
  [[nodiscard]] const Counts& counts() const { return counts_; }
  /// Time that the latest fetch() spent in the camera. For people.
  [[nodiscard]] Duration fetch_time() const { return fetch_time_; }

 private:
  [[nodiscard]] bool recover();
  void lose(Status reason);
  /// The camera gave `frame`.
  void take(const hal::Frame& frame);
  void without_frame(Status reason, Duration wait);
  [[nodiscard]] vision::Brightness brightness_of(const hal::Frame& frame) const;

  hal::Camera* camera_;
  hal::Clock& clock_;
  FrameChecks checks_;
  Duration longest_silence_;
  bool measures_ = false;
  vision::BrightnessSettings brightness_;
  int sensor_bits_ = 8;

  hal::Frame frame_;
  bool has_frame_ = false;  ///< to be used
  bool has_lease_ = false;  ///< out; also of a frame that the camera would not take back
  bool is_lost_ = false;
  std::uint32_t attempts_ = 0;
  Duration silence_;
  Duration fetch_time_;
  FeedOutcome outcome_;
  Counts counts_;
};

}  // namespace relnav::app
