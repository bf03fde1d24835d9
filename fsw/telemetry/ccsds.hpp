#pragma once
/// CCSDS Space Packet (133.0-B-2) with the PUS-C telemetry secondary header (ECSS-E-ST-70-41C, 7.4.3.1).
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "fsw/base/expected.hpp"
#include "fsw/base/status.hpp"
#include "fsw/telemetry/packets.hpp"

namespace relnav::telemetry {

inline constexpr std::size_t primary_header_bytes = 6;
inline constexpr std::size_t secondary_header_bytes = 13;
inline constexpr std::size_t crc_bytes = 2;
inline constexpr std::size_t min_packet_bytes = primary_header_bytes + secondary_header_bytes + crc_bytes;

inline constexpr std::uint16_t default_apid_base = 0x100;
inline constexpr std::uint16_t apid_max = 0x7FF;
/// From 1958-01-01 to 1970-01-01; add TAI - UTC for stamps that are Unix time.
inline constexpr std::int64_t unix_epoch_since_1958_ns = 378'691'200LL * 1'000'000'000LL;

/// Whole packet with `entries` entries, headers and CRC included.
[[nodiscard]] constexpr std::size_t packet_size(const PacketDefinition& definition, std::size_t entries = 0) {
  return min_packet_bytes + (definition.structure_id != 0 ? 2U : 0U) + body_size(definition, entries);
}

static_assert(packet_size(definition_of(PacketId::rel_state)) <= max_packet_bytes);
static_assert(packet_size(definition_of(PacketId::features), max_features_per_packet) <= max_packet_bytes);
static_assert(packet_size(definition_of(PacketId::health)) <= max_packet_bytes);
static_assert(packet_size(definition_of(PacketId::event)) <= max_packet_bytes);
static_assert(packet_size(definition_of(PacketId::time)) <= max_packet_bytes);
static_assert(packet_size(definition_of(PacketId::command_ack)) <= max_packet_bytes);
static_assert(packet_size(definition_of(PacketId::pong)) <= max_packet_bytes);

/// False for those that other software keeps for itself: 0..6, 0xFE and 0xFF (F Prime), 2045 (CFDP), 0x7FF (idle).
[[nodiscard]] constexpr bool is_usable_apid(std::uint32_t apid) {
  return apid > 6 && apid != 0xFE && apid != 0xFF && apid != 2045 && apid < apid_max;
}

struct PacketConfig {
  std::uint16_t apid_base = default_apid_base;  ///< APIDs base .. base + packet_count - 1 must all be usable
  std::uint16_t destination_id = 0;
  std::uint8_t time_reference_status = 0;  ///< 0..15
  std::int64_t epoch_offset_ns = 0;        ///< added to time_ns it gives TAI since 1958-01-01, for the header only
};

/// Status::invalid_argument when an APID is not usable or the time reference status has more than four bits.
[[nodiscard]] Status validate(const PacketConfig& config);

/// Sequence counts of a stream of packets. Counts advance with each packet encoded, whether or not it is then sent:
/// a packet that was dropped shows as a gap.
class PacketContext {
 public:
  /// Takes `config` and starts all counts at 0. On an error (see validate()) nothing changes.
  Status configure(const PacketConfig& config);
  [[nodiscard]] const PacketConfig& config() const { return config_; }

  [[nodiscard]] std::uint16_t sequence_count(PacketId id) const { return sequence_[static_cast<std::size_t>(id)]; }
  /// Messages of one type: of a packet and subtype.
  [[nodiscard]] std::uint16_t message_count(PacketId id, std::uint8_t subtype) const;
  void advance(PacketId id, std::uint8_t subtype);

 private:
  PacketConfig config_;
  std::array<std::uint16_t, packet_count> sequence_{};
  std::array<std::uint16_t, message_types> messages_{};
};

/// Both headers, as read.
struct PacketHeader {
  std::uint16_t apid = 0;
  std::uint16_t sequence_count = 0;
  std::uint16_t data_length = 0;  ///< bytes after the primary header, minus one
  std::uint8_t time_reference_status = 0;
  std::uint8_t service = 0;
  std::uint8_t subtype = 0;
  std::uint16_t message_count = 0;
  std::uint16_t destination_id = 0;
  std::uint32_t cuc_seconds = 0;   ///< TAI since 1958-01-01
  std::uint16_t cuc_fraction = 0;  ///< 1/65536 s
};

/// Length of the packet that starts at bytes[0], by its primary header: for packets one after the other in a file.
/// no_data: no bytes; incomplete: header or packet cut off.
Expected<std::size_t> framed_length(std::span<const std::uint8_t> bytes);

/// Reads the headers of one packet, `bytes` being exactly that packet. incomplete: too short, or not of the stated length;
/// crc_mismatch; unsupported: not a stand-alone PUS-C telemetry packet. `header` changes only on ok.
Status read_header(std::span<const std::uint8_t> bytes, PacketHeader& header);

}  // namespace relnav::telemetry
