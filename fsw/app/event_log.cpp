#include "fsw/app/event_log.hpp"

namespace relnav::app {
namespace {

using telemetry::EventId;

bool is_always_reported(EventId id) {
  switch (id) {
    case EventId::mode_changed:
    case EventId::configuration_accepted:
    case EventId::configuration_refused:
    case EventId::filter_reset:
    case EventId::track_acquired:
    case EventId::track_lost:
    case EventId::time_synchronised:  // at most one of these a second
    case EventId::time_lost:
    case EventId::time_jumped: return true;
    default: return false;
  }
}

}  // namespace

void EventLog::configure(std::uint32_t spacing_frames) {
  *this = EventLog();
  spacing_frames_ = spacing_frames;
}

bool EventLog::note(EventId id, std::uint32_t frame, telemetry::EventPacket& packet, std::size_t camera) {
  Entry& entry = entries_[static_cast<std::size_t>(id) - 1U];
  ++count_;
  ++entry.occurrence;
  if (entry.reported[camera] && !is_always_reported(id) && frame - entry.reported_at[camera] < spacing_frames_) {
    ++entry.suppressed;
    ++suppressed_;
    return false;
  }
  packet.event_id = static_cast<std::uint16_t>(id);
  packet.occurrence = entry.occurrence;
  packet.suppressed = entry.suppressed;
  entry.suppressed = 0;
  entry.reported[camera] = true;
  entry.reported_at[camera] = frame;
  return true;
}

}  // namespace relnav::app
