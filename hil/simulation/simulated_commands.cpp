#include "hil/simulation/simulated_commands.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace relnav::hil {

std::vector<Arrival> arrivals_of(const std::vector<PlannedCommand>& commands, const telemetry::PacketConfig& packets,
                                 Time start) {
  std::vector<Arrival> arrivals;
  for (const PlannedCommand& command : commands) {
    std::array<std::uint8_t, telemetry::max_telecommand_bytes> buffer;
    const std::size_t size = telemetry::encode_telecommand(command.id, command.argument,
                                                           static_cast<std::uint16_t>(arrivals.size()), packets, buffer)
                                 .value();
    arrivals.push_back({start + Duration{std::llround(command.at_s * 1e9)},
                        std::vector<std::uint8_t>(buffer.begin(), buffer.begin() + static_cast<std::ptrdiff_t>(size))});
  }
  return arrivals;
}

Status SimulatedCommands::receive(std::span<std::uint8_t> buffer, std::size_t& bytes) {
  if (next_ == arrivals_.size() || clock_.simulated() < arrivals_[next_].time) return Status::no_data;
  const std::vector<std::uint8_t>& packet = arrivals_[next_++].packet;
  if (packet.size() > buffer.size()) return Status::no_capacity;
  std::copy(packet.begin(), packet.end(), buffer.begin());
  bytes = packet.size();
  return Status::ok;
}

}  // namespace relnav::hil
