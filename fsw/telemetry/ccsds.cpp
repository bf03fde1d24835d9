#include "fsw/telemetry/ccsds.hpp"

#include "fsw/base/crc16.hpp"
#include "fsw/telemetry/byte_stream.hpp"

namespace relnav::telemetry {

Status validate(const PacketConfig& config) {
  for (std::uint32_t offset = 0; offset < packet_count; ++offset) {
    if (!is_usable_apid(config.apid_base + offset)) return Status::invalid_argument;
  }
  return config.time_reference_status > 15 ? Status::invalid_argument : Status::ok;
}

Status PacketContext::configure(const PacketConfig& config) {
  const Status status = validate(config);
  if (status != Status::ok) return status;
  *this = PacketContext{};
  config_ = config;
  return Status::ok;
}

std::uint16_t PacketContext::message_count(PacketId id, std::uint8_t subtype) const {
  return messages_[message_index(id, subtype)];
}

void PacketContext::advance(PacketId id, std::uint8_t subtype) {
  std::uint16_t& sequence = sequence_[static_cast<std::size_t>(id)];
  sequence = static_cast<std::uint16_t>((sequence + 1U) & 0x3FFFU);
  ++messages_[message_index(id, subtype)];
}

Expected<std::size_t> framed_length(std::span<const std::uint8_t> bytes) {
  if (bytes.empty()) return Status::no_data;
  if (bytes.size() < primary_header_bytes) return Status::incomplete;
  PacketReader length_field(bytes.subspan(4, 2));
  const std::size_t length = primary_header_bytes + length_field.u16() + 1U;
  if (bytes.size() < length) return Status::incomplete;
  return length;
}

Status read_header(std::span<const std::uint8_t> bytes, PacketHeader& header) {
  if (bytes.size() < min_packet_bytes) return Status::incomplete;
  const Expected<std::size_t> length = framed_length(bytes);
  if (!length || length.value() != bytes.size()) return Status::incomplete;
  if (crc16(bytes) != 0) return Status::crc_mismatch;

  PacketReader reader(bytes);
  const std::uint16_t identification = reader.u16();
  const std::uint16_t sequence = reader.u16();
  const std::uint16_t data_length = reader.u16();
  const std::uint8_t version_and_time_reference = reader.u8();
  // Version 0, telemetry, secondary header present; stand-alone packet; PUS-C.
  if ((identification & 0xF800U) != 0x0800U) return Status::unsupported;
  if ((sequence & 0xC000U) != 0xC000U) return Status::unsupported;
  if ((version_and_time_reference & 0xF0U) != 0x20U) return Status::unsupported;

  header.apid = static_cast<std::uint16_t>(identification & 0x07FFU);
  header.sequence_count = static_cast<std::uint16_t>(sequence & 0x3FFFU);
  header.data_length = data_length;
  header.time_reference_status = static_cast<std::uint8_t>(version_and_time_reference & 0x0FU);
  header.service = reader.u8();
  header.subtype = reader.u8();
  header.message_count = reader.u16();
  header.destination_id = reader.u16();
  header.cuc_seconds = reader.u32();
  header.cuc_fraction = reader.u16();
  return reader.status();
}

}  // namespace relnav::telemetry
