#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

#include "fsw/base/expected.hpp"
#include "fsw/base/time.hpp"
#include "fsw/telemetry/packets.hpp"

namespace relnav::app {

struct TimeMapConfig {
  /// TAI since 1958-01-01 minus the clock that stamps the pulses, within half a second: names the second of a pulse until a command
  /// does. 0 to what 32 bits of seconds count.
  Duration tai_offset{0};
  Duration tolerance{1'000'000};          ///< of a pulse's edge, jitter included; up to 100 ms
  std::int32_t max_drift_ppb = 100'000;   ///< of the clock against TAI, whatever it is; up to 500'000
  std::int32_t drift_change_ppb = 2'000;  ///< of the drift, once known, while no pulse comes; 1 to max_drift_ppb
  std::uint16_t lock_pulses = 4;          ///< this many in the window make the drift known; 2 to 16
  std::uint16_t restart_pulses = 3;  ///< edges a second apart, none where it was due: the pulses have moved; at least 2
  Duration holdover_after{2'500'000'000};  ///< since the last pulse; at least 1 s
};

/// Clock against TAI, through pulses that come with each second of TAI (PPS). Integer nanoseconds throughout; knows no clock: the
/// same edges give the same map.
///
/// The k-th pulse of the window, n_k seconds of TAI from the latest one (n_k <= 0), has the edge t_k by the clock. With
/// y_k = t_k - t_latest - 10^9 n_k ns the straight line y = a + b n of least squares through the window (e.g. Press et al.,
/// Numerical Recipes, section 15.2) gives
///   b = (N S_ny - S_n S_y) / (N S_nn - S_n^2)    drift, ns per second: 10^-9
///   a = (S_y - b S_n) / N                        the latest pulse is at t_latest + a
/// and TAI(t) = TAI_latest + (t - t_latest - a) 10^9 / (10^9 + b).
///
/// An edge is a pulse if it lies within the tolerance of a whole number n >= 1 of seconds after the latest pulse, widened by n
/// times what the drift is not known to. Any other edge is spurious and refused; when edges keep coming a second apart where
/// none was due, the pulses have moved, and the map starts anew on them.
class TimeMap {
 public:
  enum class Verdict : std::uint8_t {
    used,
    refused,
    restarted,  ///< used, and nothing before it is
  };

  struct Counts {
    std::uint32_t used = 0;
    std::uint32_t missed = 0;  ///< did not come between two that were used
    std::uint32_t refused = 0;
  };

  /// False: a value is outside of its domain; nothing changes then.
  [[nodiscard]] static bool is_valid(const TimeMapConfig& config);
  /// Forgets all pulses. For a configuration that is_valid().
  void configure(const TimeMapConfig& config);

  /// An edge of the pulse line, in the order of their times.
  [[nodiscard]] Verdict add(Time edge);
  /// The pulse used last was this second of TAI since 1958.
  void name_latest(std::uint32_t tai_seconds);

  [[nodiscard]] telemetry::SyncStatus status(Time now) const;
  [[nodiscard]] telemetry::SecondsSource seconds_source() const { return seconds_source_; }
  /// TAI since 1958. no_data: no pulse yet; outside_domain: not to be expressed, or further from the latest pulse than it is
  /// known for (so that a quarter of a second could be wrong).
  [[nodiscard]] Expected<Time> to_tai(Time clock) const;
  /// The other way, with the same errors.
  [[nodiscard]] Expected<Time> to_clock(Time tai) const;

  [[nodiscard]] const Counts& counts() const { return counts_; }
  [[nodiscard]] bool has_pulse() const { return size_ > 0; }
  /// Edge of the latest pulse used, as it came.
  [[nodiscard]] Time latest_edge() const { return latest_; }
  /// The same, smoothed.
  [[nodiscard]] Time latest_pulse() const { return Time{latest_.ns + correction_ns_}; }
  /// TAI second of it, since 1958.
  [[nodiscard]] std::int64_t latest_seconds() const { return seconds_; }
  [[nodiscard]] std::int32_t drift_ppb() const { return drift_ppb_; }
  /// Of the latest pulse: edge minus expectation; 0 for the first one.
  [[nodiscard]] Duration residual() const { return residual_; }
  /// Of the latest restart: how far the first edge of the new sequence lay from the nearest pulse expected.
  [[nodiscard]] Duration step() const { return step_; }

 private:
  static constexpr std::size_t window = 16;           ///< pulses
  static constexpr std::int64_t window_seconds = 64;  ///< the oldest pulse that counts
  static constexpr std::int64_t second_ns = 1'000'000'000;
  static constexpr std::int64_t certain_ns = 250'000'000;  ///< further off a second could be taken for the next

  struct Pulse {
    Time edge;
    std::int64_t n = 0;  ///< seconds of TAI, since the map started
  };
  struct Expectation {
    std::int64_t seconds = 0;  ///< nearest whole number after the latest pulse
    std::int64_t error_ns = 0;
    std::int64_t allowance_ns = 0;
  };

  /// By what a time so far from the latest pulse may be wrong.
  [[nodiscard]] std::int64_t allowance_ns(std::int64_t seconds) const;
  [[nodiscard]] bool is_known_at(std::int64_t since_ns) const;
  [[nodiscard]] Expectation expect(Time edge) const;
  void start(Time edge);
  void use(Time edge, const Expectation& expected);
  void fit();
  /// Counts edges that are refused but a second apart. True: enough of them.
  [[nodiscard]] bool is_new_sequence(Time edge, std::int64_t error_ns);

  TimeMapConfig config_;
  std::array<Pulse, window> pulses_{};  ///< ring
  std::size_t size_ = 0;                ///< pulses in the window; 0: none came yet
  std::size_t newest_ = 0;
  Time latest_;
  std::int64_t n_ = 0;        ///< of the latest pulse
  std::int64_t seconds_ = 0;  ///< its TAI
  std::int64_t correction_ns_ = 0;
  std::int32_t drift_ppb_ = 0;
  bool drift_known_ = false;
  telemetry::SecondsSource seconds_source_ = telemetry::SecondsSource::configuration;
  Duration residual_;
  Duration step_;
  Time stray_;                       ///< latest edge that was refused
  std::uint16_t strays_ = 0;         ///< in a row, a second apart
  std::int64_t stray_error_ns_ = 0;  ///< of the first of them
  Counts counts_;
};

}  // namespace relnav::app
