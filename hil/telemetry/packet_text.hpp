#pragma once
#include <cstdint>
#include <span>
#include <string>

#include "fsw/telemetry/codec.hpp"

namespace relnav::hil {

/// One packet as one line of text, or as one line of JSON. A packet that cannot be read gives a line that says why.
[[nodiscard]] std::string packet_text(std::span<const std::uint8_t> bytes, const telemetry::PacketConfig& config);
[[nodiscard]] std::string packet_json(std::span<const std::uint8_t> bytes, const telemetry::PacketConfig& config);

/// Line of events.log for an EVENT packet; empty for every other packet.
[[nodiscard]] std::string event_log_line(std::span<const std::uint8_t> bytes, const telemetry::PacketConfig& config);

}  // namespace relnav::hil
