#include "fsw/app/final_event.hpp"

namespace relnav::app {

Status send_final_event(hal::PacketLink& link, const telemetry::PacketConfig& packets, telemetry::EventId id,
                        Status reason, const EventArgs& args) {
  telemetry::PacketContext context;
  const Status configured = context.configure(packets);
  if (configured != Status::ok) return configured;
  telemetry::EventPacket packet;
  packet.event_id = static_cast<std::uint16_t>(id);
  packet.occurrence = 1;
  packet.status = static_cast<std::uint8_t>(reason);
  packet.args = args;
  std::array<std::uint8_t, 128> bytes{};
  const Expected<std::size_t> size = telemetry::encode(packet, context, bytes);
  return size ? link.send({bytes.data(), size.value()}) : size.status();
}

}  // namespace relnav::app
