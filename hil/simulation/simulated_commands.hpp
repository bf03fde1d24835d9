#pragma once
#include <cstdint>
#include <vector>

#include "fsw/telemetry/telecommand.hpp"
#include "hal/command_source.hpp"
#include "hil/simulation/simulated_clock.hpp"

namespace relnav::hil {

/// A telecommand of a scenario.
struct PlannedCommand {
  double at_s = 0.0;  ///< since the start; it arrives then
  telemetry::TelecommandId id = telemetry::TelecommandId::ping;
  std::uint32_t argument = 0;  ///< for set_tai
};

/// A packet on its way to the flight.
struct Arrival {
  Time time;
  std::vector<std::uint8_t> packet;
};

/// As packets of the flight that they are for.
[[nodiscard]] std::vector<Arrival> arrivals_of(const std::vector<PlannedCommand>& commands,
                                               const telemetry::PacketConfig& packets, Time start);

/// Telecommands that arrive as simulated time goes on.
class SimulatedCommands final : public hal::CommandSource {
 public:
  /// `arrivals`: by time.
  SimulatedCommands(std::vector<Arrival> arrivals, const SimulatedClock& clock)
      : arrivals_(std::move(arrivals)), clock_(clock) {}

  /// After all others.
  void add(Arrival arrival) { arrivals_.push_back(std::move(arrival)); }

  Status receive(std::span<std::uint8_t> buffer, std::size_t& bytes) override;

 private:
  std::vector<Arrival> arrivals_;
  const SimulatedClock& clock_;
  std::size_t next_ = 0;
};

}  // namespace relnav::hil
