#include "fsw/app/event_reporter.hpp"

#include "fsw/app/saturating.hpp"

namespace relnav::app {
namespace {

using telemetry::EventId;

EventId event_of(FrameFault fault) {
  switch (fault) {
    case FrameFault::size: return EventId::frame_refused_size;
    case FrameFault::format: return EventId::frame_refused_format;
    case FrameFault::age: return EventId::frame_refused_age;
    case FrameFault::no_contrast: return EventId::image_without_contrast;
    case FrameFault::frozen: return EventId::image_frozen;
    case FrameFault::none:
    case FrameFault::time_range:
    case FrameFault::time_order: break;
  }
  return EventId::frame_refused_out_of_order;
}

}  // namespace

void EventReporter::configure(const FlightLoopConfig& config) {
  expected_[0] = {config.camera.width_px, config.camera.height_px};
  expected_[1] = {config.second.intrinsics.width_px, config.second.intrinsics.height_px};
  max_age_ = config.frames.max_age;
  latest_ = stamp_ = FrameStamp();
  frames_ = 0;
}

void EventReporter::count_frame() { increment(frames_); }

void EventReporter::report(EventId id, Status status, const EventArgs& args) {
  telemetry_.send_event(id, status, stamp_, frames_, args);
}

void EventReporter::concern_frame_of(const FeedOutcome& outcome) {
  // No packet can carry a stamp that is out of range.
  const bool known = outcome.received && outcome.check.fault != FrameFault::time_range;
  stamp_ = known ? FrameStamp{outcome.frame.mid_exposure, outcome.frame.sequence} : latest_;
}

void EventReporter::camera_lost(std::size_t camera, Status reason) {
  report(EventId::camera_lost, reason, {static_cast<std::int64_t>(camera)});
}

void EventReporter::arrival(std::size_t camera, const FeedOutcome& outcome) {
  stamp_ = latest_;
  if (outcome.attempts > 0) {
    report(EventId::camera_recovered, outcome.stop_answer, {static_cast<std::int64_t>(camera), outcome.attempts});
  }
  concern_frame_of(outcome);
  if (!outcome.received || !outcome.check.gap) return;
  const FrameCheck& check = outcome.check;
  report(EventId::frame_gap, Status::ok, {outcome.frame.sequence, check.previous_sequence, check.missing_frames});
}

void EventReporter::fault(std::size_t camera, const FeedOutcome& outcome) {
  if (!outcome.refused && outcome.lost_for == Status::ok) return;
  concern_frame_of(outcome);
  if (outcome.refused) refusal(camera, outcome);
  if (outcome.lost_for != Status::ok) camera_lost(camera, outcome.lost_for);
}

void EventReporter::refusal(std::size_t camera, const FeedOutcome& outcome) {
  const hal::Frame& frame = outcome.frame;
  const FrameCheck& check = outcome.check;
  EventArgs args{};
  switch (check.fault) {
    case FrameFault::size:
      args = {frame.width_px, frame.height_px, expected_[camera].width_px, expected_[camera].height_px};
      break;
    case FrameFault::format: args = {static_cast<std::int64_t>(frame.format)}; break;
    case FrameFault::age: args = {frame.sequence, check.age.ns, max_age_.ns}; break;
    case FrameFault::no_contrast: args = {check.darkest, check.brightest}; break;
    case FrameFault::frozen: args = {check.repeats}; break;
    case FrameFault::none:
    case FrameFault::time_range:
    case FrameFault::time_order: args = {frame.sequence, frame.mid_exposure.ns, check.previous_time.ns}; break;
  }
  // A scene without contrast or a frozen image is one happening, however long it lasts.
  const bool is_episode = check.fault == FrameFault::no_contrast || check.fault == FrameFault::frozen;
  if (is_episode && !check.first_in_a_row) return;
  report(event_of(check.fault), status_of(check.fault), args);
}

void EventReporter::missing_mate(const FrameEpoch& epoch, std::uint32_t incomplete) {
  report(EventId::pair_incomplete, epoch.missing_reason,
         {static_cast<std::int64_t>(epoch.missing), epoch.stamp.time.ns, incomplete});
}

void EventReporter::torn_image(const Tear& tear) {
  telemetry_.send_event(EventId::image_torn, Status::incomplete, stamp_, frames_,
                        {tear.camera, static_cast<std::int64_t>(tear.row_px), tear.late}, tear.camera);
}

}  // namespace relnav::app
