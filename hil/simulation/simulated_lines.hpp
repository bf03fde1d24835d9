#pragma once
#include <cstdint>
#include <vector>

#include "fsw/app/line_config.hpp"
#include "hal/gpio_lines.hpp"
#include "hil/simulation/simulated_clock.hpp"
#include "platform/host/scripted_gpio_lines.hpp"

namespace relnav::hil {

/// What a scenario wires to the flight's lines, and how good it is.
struct LineSettings {
  bool heartbeat = false;
  bool pulse = false;            ///< PPS
  bool exposure = false;         ///< high while the first camera exposes; frames are stamped by the loop's clock then
  double pulse_jitter_s = 0.0;   ///< 1 sigma of each pulse
  double clock_drift_ppb = 0.0;  ///< of the loop's clock against TAI

  [[nodiscard]] bool any() const { return heartbeat || pulse || exposure; }
};

/// Lines as the flight loop is told of them.
[[nodiscard]] app::LineConfig line_config_of(const LineSettings& settings);

/// The level that comes in on a line from then on.
struct LineChange {
  Time time;
  std::uint32_t offset = 0;
  bool level = false;
};

/// Pulses of each second from `start` to `end`, by the drifting clock, a tenth of a second long.
[[nodiscard]] std::vector<LineChange> pulses_of(const LineSettings& settings, Time start, Time end, std::uint64_t seed);

/// Digital lines of a simulation: what comes in follows the simulated time, what goes out is counted.
class SimulatedLines final : public hal::GpioLines {
 public:
  /// `to_come`: by time.
  SimulatedLines(std::vector<LineChange> to_come, SimulatedClock& clock);

  /// One more, not before what has come already.
  void add(const LineChange& change);
  /// What is on the line, whoever drives it.
  [[nodiscard]] bool level(std::uint32_t offset) const { return chip_.level(offset); }
  /// Changes of level by set().
  [[nodiscard]] std::uint64_t toggles() const { return toggles_; }

  Status request_output(std::uint32_t offset, bool initial) override { return chip_.request_output(offset, initial); }
  Status request_input(std::uint32_t offset, hal::Edges edges) override;
  Status release(std::uint32_t offset) override { return chip_.release(offset); }
  Status set(std::uint32_t offset, bool level) override;
  Status get(std::uint32_t offset, bool& level) override;
  /// Simulated time goes on by `wait` where no edge has come.
  Status wait_edge(Duration wait, hal::LineEdge& edge) override;

 private:
  /// What comes in up to the simulated time.
  void play();

  platform::host::ScriptedGpioLines chip_;
  std::vector<LineChange> to_come_;
  std::size_t next_ = 0;
  SimulatedClock& clock_;
  std::uint64_t toggles_ = 0;
};

}  // namespace relnav::hil
