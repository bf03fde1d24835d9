#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

#include "fsw/app/event_reporter.hpp"
#include "fsw/app/exposure_line.hpp"
#include "fsw/app/line_config.hpp"
#include "fsw/app/telemetry_writer.hpp"
#include "fsw/app/time_map.hpp"
#include "hal/clock.hpp"
#include "hal/gpio_lines.hpp"

namespace relnav::app {

/// The digital lines of the flight loop: heartbeat out; pulses in, which make the time map and a TIME packet each; exposures in,
/// against which frames' stamps are held. A line that fails is released and requested anew, once in a step.
class LineService {
 public:
  /// `lines` may be null: nothing happens then.
  LineService(hal::GpioLines* lines, hal::Clock& clock, TelemetryWriter& telemetry, EventReporter& events)
      : gpio_(lines), clock_(clock), telemetry_(telemetry), events_(events) {}

  /// Gives all lines back and requests those of `config`, which is valid. Not ok: what the first line answered that cannot be had;
  /// none is held then.
  Status configure(const LineConfig& config);
  /// A frame was used that has this stamp, by the loop's clock.
  void frame(Time mid_exposure) { frame_ = mid_exposure; }
  /// Reads the edges that have come, most_edges of them at most.
  void serve();
  /// A step is complete.
  void beat();

  /// The next pulse after now is this second of TAI since 1958. not_configured: no pulse line; no_capacity: another one is awaited.
  Status name_next_pulse(std::uint32_t tai_seconds);
  /// True, once: what was asked for has been done (ok), or that pulse did not come (timeout).
  [[nodiscard]] bool take_naming(Status& outcome);

  [[nodiscard]] const TimeMap& time() const { return time_; }

 private:
  static constexpr int most_edges =
      32;  ///< read in one step: at 200 frames and a pulse a second enough for steps of 75 ms
  enum Role : std::size_t { heartbeat, pulse, exposure };

  struct Line {
    std::int32_t offset = LineConfig::none;
    bool held = false;
    std::uint32_t failures = 0;

    [[nodiscard]] bool exists() const { return offset != LineConfig::none; }
    [[nodiscard]] std::uint32_t number() const { return static_cast<std::uint32_t>(offset); }
  };
  /// A pulse that a command gives its second.
  struct Naming {
    enum class State : std::uint8_t { none, awaited, over };
    State state = State::none;
    Status outcome = Status::ok;
    std::uint32_t tai_seconds = 0;
    Time since;
  };

  Status request(Role role);
  void release_all();
  void fail(Role role, Status reason);
  void recover();
  void read_edges();
  void take(const hal::LineEdge& edge);
  void take_pulse(const hal::LineEdge& edge);
  void settle_naming(Time edge);
  void watch_time();
  void send_time(Time now);

  hal::GpioLines* gpio_;
  hal::Clock& clock_;
  TelemetryWriter& telemetry_;
  EventReporter& events_;
  std::array<Line, 3> lines_;  ///< by role
  bool level_ = false;         ///< of the heartbeat
  TimeMap time_;
  telemetry::SyncStatus sync_ = telemetry::SyncStatus::none;  ///< as last told
  Naming naming_;
  ExposureLine exposures_;
  Time frame_;
  bool time_due_ = false;  ///< a pulse came that no TIME packet has told of
};

}  // namespace relnav::app
