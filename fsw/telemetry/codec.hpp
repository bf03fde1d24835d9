#pragma once
/// Packets to bytes and back. Every function is reentrant; all state is in the caller's PacketContext.
#include <cstddef>
#include <cstdint>
#include <span>

#include "fsw/base/expected.hpp"
#include "fsw/base/status.hpp"
#include "fsw/telemetry/ccsds.hpp"
#include "fsw/telemetry/packets.hpp"

namespace relnav::telemetry {

/// Writes one packet to the front of `buffer` and returns its size (packet_size()). On an error nothing is written and no count
/// advances: no_capacity (buffer too small), not_finite (a NaN or infinity), outside_domain (the time has no CUC form),
/// invalid_argument (event id not in the table, part >= parts, a stage that is none).
Expected<std::size_t> encode(const RelStatePacket& packet, PacketContext& context, std::span<std::uint8_t> buffer);
Expected<std::size_t> encode(const FeaturesPacket& packet, PacketContext& context, std::span<std::uint8_t> buffer);
Expected<std::size_t> encode(const HealthPacket& packet, PacketContext& context, std::span<std::uint8_t> buffer);
Expected<std::size_t> encode(const EventPacket& packet, PacketContext& context, std::span<std::uint8_t> buffer);
Expected<std::size_t> encode(const TimePacket& packet, PacketContext& context, std::span<std::uint8_t> buffer);
Expected<std::size_t> encode(const CommandAckPacket& packet, PacketContext& context, std::span<std::uint8_t> buffer);
Expected<std::size_t> encode(const PongPacket& packet, PacketContext& context, std::span<std::uint8_t> buffer);

/// A packet whose headers, CRC and size have been checked. `body` points into the bytes it was opened from.
struct OpenedPacket {
  PacketHeader header;
  const PacketDefinition* definition = nullptr;
  std::span<const std::uint8_t> body;  ///< without structure id and CRC
  std::uint16_t entries = 0;
};

/// Checks one packet and finds its definition. Errors of read_header(), and unsupported (APID, service, subtype or structure id
/// not in the table), incomplete (body of another size than the table's).
Expected<OpenedPacket> open_packet(std::span<const std::uint8_t> bytes, const PacketConfig& config);

/// Reads one packet. Errors of open_packet(), invalid_argument (another packet, an event under the wrong severity, a TC_ACK
/// under another subtype than its stage, part >= parts), not_finite (a NaN or infinity in it). `packet` changes only on ok.
Status decode(std::span<const std::uint8_t> bytes, const PacketConfig& config, RelStatePacket& packet);
Status decode(std::span<const std::uint8_t> bytes, const PacketConfig& config, FeaturesPacket& packet);
Status decode(std::span<const std::uint8_t> bytes, const PacketConfig& config, HealthPacket& packet);
Status decode(std::span<const std::uint8_t> bytes, const PacketConfig& config, EventPacket& packet);
Status decode(std::span<const std::uint8_t> bytes, const PacketConfig& config, TimePacket& packet);
Status decode(std::span<const std::uint8_t> bytes, const PacketConfig& config, CommandAckPacket& packet);
Status decode(std::span<const std::uint8_t> bytes, const PacketConfig& config, PongPacket& packet);

}  // namespace relnav::telemetry
