#pragma once
/// Telecommands: CCSDS Space Packets (133.0-B-2) with the PUS-C telecommand secondary header (ECSS-E-ST-70-41C, 7.4.4.1).
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "fsw/base/expected.hpp"
#include "fsw/base/status.hpp"
#include "fsw/telemetry/ccsds.hpp"

namespace relnav::telemetry {

enum class TelecommandId : std::uint8_t { ping, start, stop, restart, health, set_tai };

/// One telecommand. Its data are the function id, where there is one, then `argument_bytes` bytes of argument.
struct TelecommandDefinition {
  TelecommandId id;
  const char* name;
  std::uint8_t service;
  std::uint8_t subtype;
  std::uint8_t function_id;  ///< of service 8; 0: none
  std::size_t argument_bytes;
  const char* description;
};

inline constexpr std::array<TelecommandDefinition, 6> telecommand_definitions{{
    {TelecommandId::ping, "ping", 17, 1, 0, 0, "Answered by a PONG"},
    {TelecommandId::start, "start", 8, 1, 1, 0, "STANDBY to ACQUIRE: the cameras start"},
    {TelecommandId::stop, "stop", 8, 1, 2, 0, "To STANDBY: the cameras stop, the estimate is given up"},
    {TelecommandId::restart, "restart", 8, 1, 3, 0, "The estimate is given up and searched for anew"},
    {TelecommandId::health, "health", 8, 1, 4, 0, "One HEALTH now"},
    {TelecommandId::set_tai, "set_tai", 9, 128, 0, 4,
     "Argument: the TAI second (since 1958-01-01) of the next pulse after this command has been read; done when that "
     "pulse has come"},
}};

inline constexpr std::size_t telecommand_secondary_header_bytes = 5;
inline constexpr std::size_t min_telecommand_bytes =
    primary_header_bytes + telecommand_secondary_header_bytes + crc_bytes;

[[nodiscard]] constexpr const TelecommandDefinition& definition_of(TelecommandId id) {
  return telecommand_definitions[static_cast<std::size_t>(id)];
}
/// Application data: function id and argument.
[[nodiscard]] constexpr std::size_t data_bytes(const TelecommandDefinition& definition) {
  return (definition.function_id != 0 ? 1U : 0U) + definition.argument_bytes;
}
/// Whole packet, headers and CRC included.
[[nodiscard]] constexpr std::size_t telecommand_size(const TelecommandDefinition& definition) {
  return min_telecommand_bytes + data_bytes(definition);
}
/// The largest of the table.
inline constexpr std::size_t max_telecommand_bytes = telecommand_size(definition_of(TelecommandId::set_tai));

namespace telecommand_detail {
[[nodiscard]] consteval bool table_is_in_order() {
  for (std::size_t i = 0; i < telecommand_definitions.size(); ++i) {
    if (static_cast<std::size_t>(telecommand_definitions[i].id) != i) return false;
    if (telecommand_size(telecommand_definitions[i]) > max_telecommand_bytes) return false;
  }
  return true;
}
}  // namespace telecommand_detail
static_assert(telecommand_detail::table_is_in_order(), "definition_of() indexes the table by id");

/// What identifies a telecommand in its reports. Zero as far as it could not be read.
struct TelecommandRequest {
  std::uint16_t packet_id = 0;  ///< first two bytes
  std::uint16_t sequence = 0;   ///< next two bytes
  std::uint8_t service = 0;
  std::uint8_t subtype = 0;
};

struct Telecommand {
  TelecommandRequest request;
  bool is_ours =
      false;  ///< a telecommand for our APID, by its first bytes: to be answered, whatever else is wrong with it
  TelecommandId id = TelecommandId::ping;
  std::uint32_t argument = 0;
};

/// Reads one telecommand, `bytes` being exactly that packet; trusts no byte of it. Our APID is the configured base. incomplete: too
/// short, or not of the stated length; crc_mismatch; unsupported: no stand-alone PUS-C telecommand for us, or none of the table;
/// invalid_argument: other data than the table says. `command` is set anew in any case: request and is_ours as far as they can be
/// read, the rest on ok.
Status parse_telecommand(std::span<const std::uint8_t> bytes, const PacketConfig& config, Telecommand& command);

/// Writes a telecommand to the front of `buffer` and returns its size; for tests and tools. `argument` where there is one.
/// no_capacity.
Expected<std::size_t> encode_telecommand(TelecommandId id, std::uint32_t argument, std::uint16_t sequence_count,
                                         const PacketConfig& config, std::span<std::uint8_t> buffer);

}  // namespace relnav::telemetry
