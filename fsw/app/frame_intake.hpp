#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

#include "fsw/app/camera_feed.hpp"
#include "fsw/app/camera_image.hpp"
#include "fsw/app/frame_stamp.hpp"
#include "fsw/config.hpp"

namespace relnav::app {

struct IntakeSettings {
  std::size_t cameras = 1;
  Duration wait;            ///< longest wait for a frame, and for its mate
  Duration pair_tolerance;  ///< largest difference of the stamps of a pair
  Duration restart_gap;     ///< as FrameLimits
};

/// The images of one time, from one camera or both.
struct FrameEpoch {
  /// ok: there are images; else no camera gave any, and the best of what FeedOutcome::status says of each: a frame that was
  /// refused or incomplete, then timeout, no_data, device_lost.
  Status status = Status::no_data;
  Status reason = Status::no_data;  ///< the camera's own words for it
  bool damaged = false;             ///< status is that of a damaged frame
  bool refused = false;             ///< status is that of a refused frame
  std::size_t camera = 0;           ///< the first one that gave an image; `stamp` is of its frame
  FrameStamp stamp;
  std::array<CameraImage, config::max_cameras> images;  ///< valid until give_back()
  bool restart = false;                                 ///< no camera has given a frame for longer than restart_gap
  Duration waited;                                      ///< no camera gave a frame for so long
  /// The camera whose frame is missing in a pair, and why: it was missed, late or damaged. A camera that is lost or whose frame
  /// was refused is none of these. no_camera: none is missing.
  std::size_t missing = no_camera;
  Status missing_reason = Status::ok;
  Duration acquire_time;  ///< spent in the cameras. For people

  static constexpr std::size_t no_camera = config::max_cameras;
};

/// What the flight loop asks for images: the earliest frame of either camera, with that of the other if it is of the same time.
/// The two are treated alike. A later frame waits, on its lease; one that comes after its time has been dealt with is dropped.
class FrameIntake {
 public:
  /// `second` may be null.
  FrameIntake(hal::Camera& first, hal::Camera* second, hal::Clock& clock)
      : feeds_{CameraFeed(&first, clock), CameraFeed(second, clock)} {}

  [[nodiscard]] bool has(std::size_t camera) const { return feeds_[camera].exists(); }
  /// Forgets everything. The feeds of these cameras are to be configured as well.
  void configure(const IntakeSettings& settings);
  [[nodiscard]] std::size_t cameras() const { return settings_.cameras; }
  [[nodiscard]] CameraFeed& feed(std::size_t camera) { return feeds_[camera]; }
  [[nodiscard]] const CameraFeed& feed(std::size_t camera) const { return feeds_[camera]; }

  /// All cameras; if one fails those before it are stopped again. `camera`: the one whose answer it is.
  Status start(std::size_t& camera);
  /// All cameras, whatever they say; the first answer that is not ok.
  Status stop();

  /// Waits at most twice the wait set, and once more for each late frame. Images stay leased until give_back().
  [[nodiscard]] FrameEpoch gather();
  /// Of one camera's image in the epoch gathered last; does nothing if it gave none. Not ok: that camera is lost.
  Status give_back(std::size_t camera);
  void accept_new_time_base();

  /// Frames that came damaged, or are missing in a pair.
  [[nodiscard]] std::uint32_t incomplete() const { return incomplete_; }

 private:
  static constexpr int most_late = 16;       ///< late frames dropped in one call
  static constexpr int most_passed_by = 10;  ///< epochs that a frame waits which is a restart_gap ahead

  void fetch(std::size_t camera, Duration wait, Duration already_waited, FrameEpoch& epoch);
  void fetch_pair(FrameEpoch& epoch);
  /// Its time, or a later one, has been dealt with.
  [[nodiscard]] bool is_late(const hal::Frame& frame) const { return has_epoch_ && frame.mid_exposure <= epoch_time_; }
  void choose(FrameEpoch& epoch);
  void keep_waiting(std::size_t camera, Duration ahead);
  void look_for_mate(FrameEpoch& epoch);
  void say_why_not(FrameEpoch& epoch);

  IntakeSettings settings_;
  std::array<CameraFeed, config::max_cameras> feeds_;
  std::array<bool, config::max_cameras> in_epoch_{};
  std::array<int, config::max_cameras> passed_by_{};  ///< epochs, of a frame that waits
  bool has_epoch_ = false;
  Time epoch_time_;
  std::uint32_t incomplete_ = 0;
};

}  // namespace relnav::app
