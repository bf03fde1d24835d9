#pragma once
#include <cstdint>

#include "fsw/app/flight_config.hpp"
#include "fsw/app/frame_intake.hpp"
#include "fsw/app/telemetry_writer.hpp"
#include "fsw/estimation/torn_image.hpp"

namespace relnav::app {

/// Makes EVENT packets of what happened, each about the frame that it concerns. Keeps the count of frames by which the event log
/// spaces its reports.
class EventReporter {
 public:
  explicit EventReporter(TelemetryWriter& telemetry) : telemetry_(telemetry) {}

  void configure(const FlightLoopConfig& config);
  /// A new step. `latest`: the frame used last; events concern it until there is another.
  void begin_step(const FrameStamp& latest) { latest_ = stamp_ = latest; }
  /// From here on events concern this frame.
  void concern(const FrameStamp& stamp) { stamp_ = stamp; }
  /// One more frame, or a fault in its place, since configure().
  void count_frame();
  [[nodiscard]] std::uint32_t frames() const { return frames_; }

  void report(telemetry::EventId id, Status status, const EventArgs& args = {});

  void camera_lost(std::size_t camera, Status reason);
  /// How a camera got to its frame: started anew, after a gap.
  void arrival(std::size_t camera, const FeedOutcome& outcome);
  /// What went wrong with it: the frame is refused, the camera lost.
  void fault(std::size_t camera, const FeedOutcome& outcome);
  /// `incomplete`: frames so far.
  void missing_mate(const FrameEpoch& epoch, std::uint32_t incomplete);
  void torn_image(const Tear& tear);

 private:
  void concern_frame_of(const FeedOutcome& outcome);
  void refusal(std::size_t camera, const FeedOutcome& outcome);

  TelemetryWriter& telemetry_;
  /// What frames should be.
  struct Expected {
    std::int64_t width_px = 0;
    std::int64_t height_px = 0;
  };
  std::array<Expected, config::max_cameras> expected_{};
  Duration max_age_;
  FrameStamp latest_;
  FrameStamp stamp_;
  std::uint32_t frames_ = 0;
};

}  // namespace relnav::app
