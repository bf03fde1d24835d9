// Simulated lines and telecommands behind the HAL: the contracts that all lines and sources keep, and what a scenario plans.
#include <cmath>
#include <vector>

#include "hil/simulation/simulated_commands.hpp"
#include "hil/simulation/simulated_lines.hpp"
#include "tests/contract/command_source_contract.hpp"
#include "tests/contract/gpio_lines_contract.hpp"

namespace {

using namespace relnav;
using namespace relnav::hil;

constexpr Time start_time{1'000'000'000};

class SimulatedLinesHarness {
 public:
  hal::GpioLines& lines() { return lines_; }
  std::uint32_t line_a() const { return 3; }
  std::uint32_t line_b() const { return 7; }
  std::uint32_t no_line() const { return 8; }
  bool level(std::uint32_t offset) const { return lines_.level(offset); }
  bool drive(std::uint32_t offset, bool level) {
    const Time next = clock_.simulated() + Duration{10};
    lines_.add({next, offset, level});
    clock_.advance_to(next, next);
    return true;
  }
  std::size_t unread_edges() const { return 64; }
  bool lose_device() { return false; }
  void restore_device() {}
  Duration wait() const { return {1000}; }
  Time now() const { return clock_.simulated(); }
  Duration slack() const { return {0}; }

 private:
  SimulatedClock clock_{start_time, false};
  SimulatedLines lines_{{}, clock_};
};

class SimulatedCommandsHarness {
 public:
  hal::CommandSource& source() { return source_; }
  void arrive(const std::vector<std::uint8_t>& packet) { source_.add({clock_.simulated(), packet}); }
  bool fail_next(Status) { return false; }
  Time now() const { return clock_.simulated(); }
  Duration slack() const { return {0}; }

 private:
  SimulatedClock clock_{start_time, false};
  SimulatedCommands source_{{}, clock_};
};

}  // namespace

RELNAV_GPIO_LINES_CONTRACT(SimulatedLinesContract, SimulatedLinesHarness)
RELNAV_COMMAND_SOURCE_CONTRACT(SimulatedCommandsContract, SimulatedCommandsHarness)

TEST_GROUP(SimulatedPeripherals) { SimulatedClock clock{start_time, false}; };

TEST(SimulatedPeripherals, PulsesComeWithEachSecondOfADriftingClock) {
  LineSettings settings;
  settings.pulse_jitter_s = 2e-6;
  settings.clock_drift_ppb = 50'000.0;
  const auto changes = pulses_of(settings, start_time, start_time + Duration{200'500'000'000}, 5);
  LONGS_EQUAL(400, changes.size());
  double square_sum = 0.0;
  for (std::size_t k = 0; k < 200; ++k) {
    CHECK_TRUE(changes[2 * k].level && !changes[2 * k + 1].level);
    CHECK_TRUE(k == 0 || changes[2 * k - 1].time < changes[2 * k].time);
    const double off_ns =
        static_cast<double>((changes[2 * k].time - start_time).ns) - (1e9 + 50'000.0) * static_cast<double>(k + 1);
    square_sum += off_ns * off_ns;
  }
  // 200 draws: the standard deviation within 4 of its own (5 %).
  DOUBLES_EQUAL(2000.0, std::sqrt(square_sum / 200.0), 400.0);
  CHECK_TRUE(pulses_of(settings, start_time, start_time + Duration{900'000'000}, 5).empty());
}

TEST(SimulatedPeripherals, AnEdgeIsSeenWhenItsTimeHasComeAndKeepsItsTime) {
  const Time edge_time = start_time + Duration{500};
  SimulatedLines lines({{edge_time, 1, true}}, clock);
  CHECK_TRUE(lines.request_input(1, hal::Edges::rising) == Status::ok);
  hal::LineEdge edge;
  CHECK_TRUE(lines.wait_edge(Duration{0}, edge) == Status::no_data);
  clock.advance_to(start_time + Duration{2000}, start_time + Duration{3000});
  CHECK_TRUE(lines.wait_edge(Duration{0}, edge) == Status::ok);
  CHECK_TRUE(edge.time == edge_time && edge.clock == hal::ClockId::tai);
}

TEST(SimulatedPeripherals, HeartbeatsAreCounted) {
  SimulatedLines lines({}, clock);
  CHECK_TRUE(lines.request_output(0, false) == Status::ok);
  for (const bool level : {true, false, false, true}) CHECK_TRUE(lines.set(0, level) == Status::ok);
  LONGS_EQUAL(3, lines.toggles());
}

TEST(SimulatedPeripherals, ACommandArrivesAtItsTime) {
  telemetry::PacketConfig packets;
  SimulatedCommands source(
      arrivals_of({{0.5, telemetry::TelecommandId::stop}, {0.5, telemetry::TelecommandId::set_tai, 77}}, packets,
                  start_time),
      clock);
  std::array<std::uint8_t, 64> buffer{};
  std::size_t bytes = 0;
  clock.advance_to(start_time + Duration{499'999'999}, start_time + Duration{500'000'000});
  CHECK_TRUE(source.receive(buffer, bytes) == Status::no_data);
  clock.advance_to(start_time + Duration{500'000'000}, start_time + Duration{600'000'000});
  telemetry::Telecommand command;
  CHECK_TRUE(source.receive(buffer, bytes) == Status::ok);
  CHECK_TRUE(telemetry::parse_telecommand(std::span(buffer).first(bytes), packets, command) == Status::ok);
  CHECK_TRUE(command.id == telemetry::TelecommandId::stop);
  CHECK_TRUE(source.receive(buffer, bytes) == Status::ok);
  CHECK_TRUE(telemetry::parse_telecommand(std::span(buffer).first(bytes), packets, command) == Status::ok);
  CHECK_TRUE(command.id == telemetry::TelecommandId::set_tai);
  LONGS_EQUAL(77, command.argument);
  CHECK_TRUE(source.receive(buffer, bytes) == Status::no_data);
}
