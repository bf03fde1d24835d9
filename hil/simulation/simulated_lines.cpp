#include "hil/simulation/simulated_lines.hpp"

#include <algorithm>
#include <cmath>

#include "hil/scenarios/gaussian.hpp"

namespace relnav::hil {
namespace {

constexpr std::int32_t heartbeat_line = 0;
constexpr std::int32_t pulse_line = 1;
constexpr std::int32_t exposure_line = 2;
constexpr std::uint32_t lines_of_chip = 8;
constexpr Duration pulse_length{100'000'000};

}  // namespace

app::LineConfig line_config_of(const LineSettings& settings) {
  app::LineConfig config;
  if (settings.heartbeat) config.heartbeat = heartbeat_line;
  if (settings.pulse) config.pulse = pulse_line;
  if (settings.exposure) config.exposure = exposure_line;
  return config;
}

std::vector<LineChange> pulses_of(const LineSettings& settings, Time start, Time end, std::uint64_t seed) {
  std::vector<LineChange> changes;
  Gaussian gaussian(seed ^ 0x9E5U);
  const double second_ns = 1e9 + settings.clock_drift_ppb;
  for (double k = 1.0;; k += 1.0) {
    const double jitter_ns = 1e9 * settings.pulse_jitter_s * gaussian.next();
    const Time edge = start + Duration{std::llround(k * second_ns + jitter_ns)};
    if (edge > end) return changes;
    changes.push_back({edge, pulse_line, true});
    changes.push_back({edge + pulse_length, pulse_line, false});
  }
}

SimulatedLines::SimulatedLines(std::vector<LineChange> to_come, SimulatedClock& clock)
    : chip_(lines_of_chip), to_come_(std::move(to_come)), clock_(clock) {}

void SimulatedLines::add(const LineChange& change) {
  const auto after = std::upper_bound(to_come_.begin() + static_cast<std::ptrdiff_t>(next_), to_come_.end(), change,
                                      [](const LineChange& a, const LineChange& b) { return a.time < b.time; });
  to_come_.insert(after, change);
}

void SimulatedLines::play() {
  for (; next_ < to_come_.size() && to_come_[next_].time <= clock_.simulated(); ++next_) {
    const LineChange& change = to_come_[next_];
    static_cast<void>(chip_.drive(change.offset, change.level, change.time));  // refused: nobody listens to that line
  }
}

Status SimulatedLines::request_input(std::uint32_t offset, hal::Edges edges) {
  play();
  return chip_.request_input(offset, edges);
}

Status SimulatedLines::set(std::uint32_t offset, bool level) {
  const bool before = chip_.level(offset);
  const Status status = chip_.set(offset, level);
  if (status == Status::ok && level != before) ++toggles_;
  return status;
}

Status SimulatedLines::get(std::uint32_t offset, bool& level) {
  play();
  return chip_.get(offset, level);
}

Status SimulatedLines::wait_edge(Duration wait, hal::LineEdge& edge) {
  play();
  Status status = chip_.wait_edge(Duration{0}, edge);
  if (status == Status::no_data && wait.ns > 0) {
    const Time until = clock_.simulated() + wait;
    clock_.advance_to(until, until);
    play();
    status = chip_.wait_edge(Duration{0}, edge);
    if (status == Status::no_data) status = Status::timeout;
  }
  if (status == Status::ok) edge.clock = clock_.id();
  return status;
}

}  // namespace relnav::hil
