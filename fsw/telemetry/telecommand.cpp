#include "fsw/telemetry/telecommand.hpp"

#include "fsw/base/crc16.hpp"
#include "fsw/telemetry/byte_stream.hpp"

namespace relnav::telemetry {
namespace {

/// Version 0, telecommand, secondary header present; the APID is added.
constexpr std::uint16_t telecommand_type = 0x1800;
constexpr std::uint16_t stand_alone = 0xC000;
/// PUS-C, and all four kinds of reports asked for.
constexpr std::uint8_t version_and_reports = 0x2F;

/// nullptr: not in the table. `function_id` is looked at in service 8 only.
const TelecommandDefinition* find(std::uint8_t service, std::uint8_t subtype, std::uint8_t function_id) {
  for (const TelecommandDefinition& d : telecommand_definitions) {
    if (d.service != service || d.subtype != subtype) continue;
    if (d.function_id == 0 || d.function_id == function_id) return &d;
  }
  return nullptr;
}

}  // namespace

Status parse_telecommand(std::span<const std::uint8_t> bytes, const PacketConfig& config, Telecommand& command) {
  command = Telecommand();
  if (bytes.size() < primary_header_bytes) return Status::incomplete;
  PacketReader reader(bytes);
  command.request.packet_id = reader.u16();
  command.request.sequence = reader.u16();
  const std::size_t stated = primary_header_bytes + reader.u16() + 1U;
  command.is_ours = command.request.packet_id == (telecommand_type | config.apid_base);
  if (bytes.size() != stated || bytes.size() < min_telecommand_bytes) return Status::incomplete;
  if (crc16(bytes) != 0) return Status::crc_mismatch;
  if (!command.is_ours || (command.request.sequence & stand_alone) != stand_alone) return Status::unsupported;

  const std::uint8_t version = reader.u8();
  command.request.service = reader.u8();
  command.request.subtype = reader.u8();
  static_cast<void>(reader.u16());  // source id: nothing here depends on who asks
  if ((version & 0xF0U) != 0x20U) return Status::unsupported;

  const std::size_t size = reader.remaining() - crc_bytes;
  const std::uint8_t function_id = size > 0 ? bytes[min_telecommand_bytes - crc_bytes] : std::uint8_t{0};
  const TelecommandDefinition* definition = find(command.request.service, command.request.subtype, function_id);
  if (definition == nullptr) return Status::unsupported;
  if (size != data_bytes(*definition)) return Status::invalid_argument;
  if (definition->function_id != 0) static_cast<void>(reader.u8());
  if (definition->argument_bytes != 0) command.argument = reader.u32();
  command.id = definition->id;
  return Status::ok;
}

Expected<std::size_t> encode_telecommand(TelecommandId id, std::uint32_t argument, std::uint16_t sequence_count,
                                         const PacketConfig& config, std::span<std::uint8_t> buffer) {
  const TelecommandDefinition& definition = definition_of(id);
  const std::size_t size = telecommand_size(definition);
  if (buffer.size() < size) return Status::no_capacity;
  PacketWriter writer(buffer.first(size));
  writer.u16(static_cast<std::uint16_t>(telecommand_type | config.apid_base));
  writer.u16(static_cast<std::uint16_t>(stand_alone | (sequence_count & 0x3FFFU)));
  writer.u16(static_cast<std::uint16_t>(size - primary_header_bytes - 1U));
  writer.u8(version_and_reports);
  writer.u8(definition.service);
  writer.u8(definition.subtype);
  writer.u16(0);
  if (definition.function_id != 0) writer.u8(definition.function_id);
  if (definition.argument_bytes != 0) writer.u32(argument);
  writer.u16(crc16(writer.written()));
  return writer.size();
}

}  // namespace relnav::telemetry
