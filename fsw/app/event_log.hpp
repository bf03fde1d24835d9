#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

#include "fsw/config.hpp"
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
  /// `camera`: of an event that two cameras may have at once, and that is spaced for each by itself.
  [[nodiscard]] bool note(telemetry::EventId id, std::uint32_t frame, telemetry::EventPacket& packet,
                          std::size_t camera = 0);
  /// Events so far, reported or not.
  [[nodiscard]] std::uint32_t count() const { return count_; }
  [[nodiscard]] std::uint32_t suppressed() const { return suppressed_; }

 private:
  struct Entry {
    std::uint32_t occurrence = 0;
    std::uint32_t suppressed = 0;
    std::array<std::uint32_t, config::max_cameras> reported_at{};
    std::array<bool, config::max_cameras> reported{};
  };
  std::array<Entry, telemetry::event_definitions.size()> entries_{};
  std::uint32_t spacing_frames_ = 0;
  std::uint32_t count_ = 0;
  std::uint32_t suppressed_ = 0;
};

}  // namespace relnav::app
