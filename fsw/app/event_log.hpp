#pragma once
#include <array>
#include <cstdint>

#include "fsw/telemetry/events.hpp"
#include "fsw/telemetry/packets.hpp"

namespace relnav::app {

/// Counts events and keeps one kind from flooding the link: after a report of an event the next one of the same id comes
/// at the earliest `spacing` frames later, with the number left out in between. Changes of mode, resets, the
/// configuration, and what becomes of the time are always reported.
class EventLog {
 public:
  void configure(std::uint32_t spacing_frames);
  /// Counts one event at frame number `frame` (never going back). True: report it; the counts of `packet` are then set.
  [[nodiscard]] bool note(telemetry::EventId id, std::uint32_t frame, telemetry::EventPacket& packet);
  /// Events so far, reported or not.
  [[nodiscard]] std::uint32_t count() const { return count_; }
  [[nodiscard]] std::uint32_t suppressed() const { return suppressed_; }

 private:
  struct Entry {
    std::uint32_t occurrence = 0;
    std::uint32_t suppressed = 0;
    std::uint32_t reported_at = 0;
    bool reported = false;
  };
  std::array<Entry, telemetry::event_definitions.size()> entries_{};
  std::uint32_t spacing_frames_ = 0;
  std::uint32_t count_ = 0;
  std::uint32_t suppressed_ = 0;
};

}  // namespace relnav::app
