#include "fsw/app/frame_checks.hpp"

#include <algorithm>
#include <bit>
#include <cstring>

namespace relnav::app {
namespace {

/// Of one row, continuing `sum`: only ever compared with itself on the same machine.
std::uint64_t add_row(std::uint64_t sum, const std::uint8_t* row, std::uint32_t bytes) {
  constexpr std::uint64_t factor = 0x9E3779B97F4A7C15ULL;
  std::uint32_t i = 0;
  for (; i + 8U <= bytes; i += 8U) {
    std::uint64_t word = 0;
    std::memcpy(&word, row + i, 8U);
    sum = (sum ^ word) * factor;
    sum ^= sum >> 32U;
  }
  for (; i < bytes; ++i) {
    sum = (sum ^ row[i]) * factor;
    sum ^= sum >> 32U;
  }
  return sum;
}

std::uint32_t bytes_per_pixel(const hal::Frame& frame) { return frame.format == hal::PixelFormat::mono16 ? 2 : 1; }

}  // namespace

void FrameChecks::configure(const FrameLimits& limits, std::uint32_t width_px, std::uint32_t height_px,
                            int sensor_bits) {
  *this = FrameChecks();
  limits_ = limits;
  width_px_ = width_px;
  height_px_ = height_px;
  sensor_bits_ = sensor_bits;
}

FrameCheck FrameChecks::check(const hal::Frame& frame, Time now, hal::ClockId now_clock) {
  FrameCheck out;
  out.previous_time = latest_;
  out.previous_sequence = sequence_;
  out.fault = judge(frame, now, now_clock, out);
  out.first_in_a_row = out.fault != previous_fault_;
  previous_fault_ = out.fault;
  return out;
}

FrameFault FrameChecks::judge(const hal::Frame& frame, Time now, hal::ClockId now_clock, FrameCheck& out) {
  const FrameFault form = judge_form(frame);
  if (form != FrameFault::none) return form;
  const FrameFault time = judge_time(frame, out);
  if (time != FrameFault::none) return time;
  const FrameFault image = judge_image(frame, out);
  if (limits_.max_age.ns > 0 && frame.clock == now_clock) {
    out.age = now - frame.mid_exposure;
    if (out.age > limits_.max_age) return FrameFault::age;
  }
  return image;
}

FrameFault FrameChecks::judge_form(const hal::Frame& frame) const {
  const bool deep = frame.format == hal::PixelFormat::mono16;
  if (frame.format != hal::PixelFormat::mono8 && !(deep && sensor_bits_ > 8)) return FrameFault::format;
  const std::uint32_t bytes = bytes_per_pixel(frame);
  const bool aligned = std::bit_cast<std::uintptr_t>(frame.pixels) % bytes == 0 && frame.stride_bytes % bytes == 0;
  const bool fits = frame.pixels != nullptr && frame.width_px == width_px_ && frame.height_px == height_px_ &&
                    frame.stride_bytes >= bytes * frame.width_px && frame.stride_bytes <= 0x00FFFFFFU && aligned;
  return fits ? FrameFault::none : FrameFault::size;
}

FrameFault FrameChecks::judge_time(const hal::Frame& frame, FrameCheck& out) {
  const Time time = frame.mid_exposure;
  if (time.ns < 0 || time.ns > limits_.latest_time_ns) return FrameFault::time_range;
  const bool first = !have_time_;
  const Time before = new_time_base_ ? received_ : latest_;
  received_ = time;
  if (!first && time <= before) return FrameFault::time_order;
  const bool continues = !first && time > latest_;
  if (continues) {
    look_for_gap(frame, out);
    periods_ns_[periods_ % periods_kept] = (time - latest_).ns;
    ++periods_;
  } else {
    periods_ = 0;
  }
  have_time_ = true;
  new_time_base_ = false;
  latest_ = time;
  sequence_ = frame.sequence;
  return FrameFault::none;
}

void FrameChecks::look_for_gap(const hal::Frame& frame, FrameCheck& out) {
  constexpr std::uint32_t most_missing = 0x7FFFFFFFU;  // further apart is a camera that counts anew
  const std::uint32_t step = frame.sequence - sequence_;
  if (step > 1 && step <= most_missing) out.missing_by_sequence = step - 1;
  const std::int64_t gap_ns = (frame.mid_exposure - latest_).ns;
  const std::int64_t period_ns = median_period_ns();
  std::int64_t missing = out.missing_by_sequence;
  if (period_ns > 0 && gap_ns / period_ns > limits_.gap_periods) {
    out.gap = true;
    missing = std::max(missing, gap_ns / period_ns - 1);
  }
  out.gap = out.gap || out.missing_by_sequence > 0;
  out.missing_frames = static_cast<std::uint32_t>(std::min<std::int64_t>(missing, most_missing));
  if (gap_ns > limits_.restart_gap.ns) {
    out.gap = true;
    out.restart = true;
  }
}

std::int64_t FrameChecks::median_period_ns() const {
  const std::size_t count = std::min(periods_, periods_kept);
  if (count < 3) return 0;
  std::array<std::int64_t, periods_kept> sorted = periods_ns_;
  for (std::size_t i = 1; i < count; ++i) {
    const std::int64_t value = sorted[i];
    std::size_t k = i;
    for (; k > 0 && sorted[k - 1] > value; --k) sorted[k] = sorted[k - 1];
    sorted[k] = value;
  }
  return sorted[count / 2];
}

void FrameChecks::look_at_levels(const hal::Frame& frame, FrameCheck& out) const {
  // Byte by byte: rows of 16-bit pixels are aligned, but belong to the driver.
  const bool deep = bytes_per_pixel(frame) == 2;
  const int shift = deep ? sensor_bits_ - 8 : 0;
  std::uint32_t darkest = 0xFFFFU;
  std::uint32_t brightest = 0;
  for (std::uint32_t v = 0; v < height_px_; v += row_step) {
    const std::uint8_t* row = frame.pixels + static_cast<std::size_t>(v) * frame.stride_bytes;
    for (std::uint32_t u = 0; u < width_px_; ++u) {
      std::uint16_t level = 0;
      if (deep) {
        std::memcpy(&level, row + 2U * u, sizeof level);
      } else {
        level = row[u];
      }
      darkest = std::min<std::uint32_t>(darkest, level);
      brightest = std::max<std::uint32_t>(brightest, level);
    }
  }
  out.darkest = static_cast<std::uint8_t>(std::min<std::uint32_t>(darkest >> shift, 255U));
  out.brightest = static_cast<std::uint8_t>(std::min<std::uint32_t>(brightest >> shift, 255U));
}

FrameFault FrameChecks::judge_image(const hal::Frame& frame, FrameCheck& out) {
  look_at_levels(frame, out);
  std::uint64_t sum = 0;
  for (std::uint32_t v = 0; v < height_px_; v += row_step) {
    sum = add_row(sum, frame.pixels + static_cast<std::size_t>(v) * frame.stride_bytes,
                  bytes_per_pixel(frame) * width_px_);
  }
  const bool repeats = have_checksum_ && sum == checksum_;
  have_checksum_ = true;
  checksum_ = sum;
  if (!repeats) {
    repeats_ = 0;
  } else if (repeats_ < 0xFFFFFFFFU) {
    ++repeats_;
  }
  out.repeats = repeats_;
  if (out.brightest - out.darkest < limits_.min_contrast) return FrameFault::no_contrast;
  if (limits_.refuse_frozen && repeats) return FrameFault::frozen;
  return FrameFault::none;
}

}  // namespace relnav::app
