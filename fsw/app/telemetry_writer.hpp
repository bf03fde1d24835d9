#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

#include "fsw/app/event_log.hpp"
#include "fsw/app/frame_stamp.hpp"
#include "fsw/app/step_report.hpp"
#include "fsw/telemetry/codec.hpp"
#include "hal/packet_link.hpp"

namespace relnav::app {

/// How far `state` may be believed.
struct StateValidity {
  bool estimate = false;     ///< there is one
  bool scale_known = false;  ///< metres are metres
  bool predicted = false;    ///< no measurement of the frame went into it
};

using EventArgs = std::array<std::int64_t, 4>;

/// Makes packets and hands them to the link. A packet that the link does not take is counted and gone.
class TelemetryWriter {
 public:
  explicit TelemetryWriter(hal::PacketLink& link) : link_(link) {}

  /// Starts all counts anew. Errors as telemetry::validate(); nothing changes then.
  Status configure(const telemetry::PacketConfig& config, std::uint32_t event_spacing_frames);

  void send_state(const StepReport& report, const FrameStamp& stamp, const StateValidity& validity);
  /// In as many packets as it takes.
  void send_features(const StepReport& report, const FrameStamp& stamp);
  /// The counts that this writer keeps are filled in.
  void send_health(telemetry::HealthPacket packet);
  void send_time(const telemetry::TimePacket& packet);
  void send_command_ack(const telemetry::CommandAckPacket& packet);
  void send_pong(const telemetry::PongPacket& packet);
  /// At most every so often, see EventLog. `frame`: number of the frame since start, for the spacing.
  void send_event(telemetry::EventId id, Status status, const FrameStamp& stamp, std::uint32_t frame,
                  const EventArgs& args = {}, std::size_t camera = 0);

  /// Packets that the link refused, or that could not be made.
  [[nodiscard]] std::uint32_t dropped() const { return dropped_; }
  [[nodiscard]] const EventLog& events() const { return events_; }

 private:
  template <typename Packet>
  void send(const Packet& packet);

  hal::PacketLink& link_;
  telemetry::PacketContext context_;
  EventLog events_;
  std::array<std::uint8_t, telemetry::max_packet_bytes> buffer_{};
  telemetry::FeaturesPacket features_;  // too large for a stack
  std::uint32_t dropped_ = 0;
};

}  // namespace relnav::app
