#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

#include "fsw/base/status.hpp"
#include "fsw/base/time.hpp"
#include "hal/frame.hpp"

namespace relnav::app {

struct FrameLimits {
  std::uint16_t gap_periods = 10;        ///< a step between stamps longer than this many median periods is a gap
  Duration restart_gap{30'000'000'000};  ///< a longer step ends what the filter may bridge
  Duration max_age{0};                   ///< from mid-exposure to now, where both are of one clock; 0: no limit
  std::int64_t latest_time_ns = 4'294'967'295'999'999'999;  ///< last stamp that telemetry can carry
  std::uint8_t min_contrast = 16;  ///< brightest minus darkest level, of 255; 0 switches the check off
  bool refuse_frozen = true;       ///< an image equal to the one before it is not used
};

enum class FrameFault : std::uint8_t { none, size, format, time_range, time_order, age, no_contrast, frozen };

/// What report.status says of a frame with this fault.
[[nodiscard]] constexpr Status status_of(FrameFault fault) {
  switch (fault) {
    case FrameFault::none: return Status::ok;
    case FrameFault::size: return Status::invalid_argument;
    case FrameFault::format: return Status::unsupported;
    case FrameFault::time_range: return Status::outside_domain;
    case FrameFault::time_order: return Status::out_of_order;
    case FrameFault::age: return Status::timeout;
    case FrameFault::no_contrast: return Status::incomplete;
    case FrameFault::frozen: return Status::incomplete;
  }
  return Status::invalid_argument;
}

struct FrameCheck {
  FrameFault fault = FrameFault::none;
  bool first_in_a_row = true;        ///< the frame before did not have the same fault
  bool gap = false;                  ///< in time or sequence, before this frame
  bool restart = false;              ///< the gap is longer than restart_gap
  std::uint32_t missing_frames = 0;  ///< by sequence number, else estimated from the gap in time
  std::uint32_t missing_by_sequence = 0;
  std::uint32_t previous_sequence = 0;
  Time previous_time;
  Duration age;
  std::uint8_t darkest = 0;
  std::uint8_t brightest = 0;
  std::uint32_t repeats = 0;  ///< identical images in a row so far
};

/// Decides whether a frame may be used. Looks at every fourth row of the image. Bounded time, no allocation.
class FrameChecks {
 public:
  /// Forgets all frames.
  /// `sensor_bits`: 8: only mono8 is taken; up to 16: mono16 as well, with full scale at 2^sensor_bits - 1.
  void configure(const FrameLimits& limits, std::uint32_t width_px, std::uint32_t height_px, int sensor_bits = 8);
  /// Lets a new time base in: the next frame only has to be later than the one received before it.
  void accept_new_time_base() { new_time_base_ = true; }
  [[nodiscard]] FrameCheck check(const hal::Frame& frame, Time now, hal::ClockId now_clock);

 private:
  static constexpr std::size_t periods_kept = 9;
  static constexpr std::uint32_t row_step = 4;

  [[nodiscard]] FrameFault judge(const hal::Frame& frame, Time now, hal::ClockId now_clock, FrameCheck& out);
  [[nodiscard]] FrameFault judge_form(const hal::Frame& frame) const;
  [[nodiscard]] FrameFault judge_time(const hal::Frame& frame, FrameCheck& out);
  [[nodiscard]] FrameFault judge_image(const hal::Frame& frame, FrameCheck& out);
  /// Darkest and brightest level, of 255.
  void look_at_levels(const hal::Frame& frame, FrameCheck& out) const;
  void look_for_gap(const hal::Frame& frame, FrameCheck& out);
  /// 0 until three periods are known.
  [[nodiscard]] std::int64_t median_period_ns() const;

  FrameLimits limits_;
  std::uint32_t width_px_ = 0;
  std::uint32_t height_px_ = 0;
  int sensor_bits_ = 8;
  bool have_time_ = false;
  bool new_time_base_ = false;
  Time latest_;    ///< of the frames in order
  Time received_;  ///< of the previous frame, whatever became of it
  std::uint32_t sequence_ = 0;
  std::array<std::int64_t, periods_kept> periods_ns_{};
  std::size_t periods_ = 0;  ///< seen so far
  bool have_checksum_ = false;
  std::uint64_t checksum_ = 0;
  std::uint32_t repeats_ = 0;
  FrameFault previous_fault_ = FrameFault::none;
};

}  // namespace relnav::app
