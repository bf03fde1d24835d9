#include "fsw/app/auto_exposure.hpp"

#include <algorithm>
#include <cmath>

#include "fsw/app/saturating.hpp"

namespace relnav::app {
namespace {

constexpr double most_factor = 1e3;
constexpr double most_gain = 1e6;
constexpr std::int64_t most_exposure_ns = 60'000'000'000;
/// Of what is over-exposed in too large a part, but not as a whole.
constexpr double step_down = 1.5;

bool lies_in(double value, double low, double high) { return std::isfinite(value) && value >= low && value <= high; }

double product_of(const hal::Exposure& exposure) { return static_cast<double>(exposure.time.ns) * exposure.gain; }

Duration clamped_time(double time_ns, const hal::ExposureLimits& limits) {
  const double inside =
      std::clamp(time_ns, static_cast<double>(limits.time_min.ns), static_cast<double>(limits.time_max.ns));
  return {std::clamp(static_cast<std::int64_t>(inside + 0.5), limits.time_min.ns, limits.time_max.ns)};
}

}  // namespace

bool AutoExposureConfig::is_valid() const {
  if (!brightness.is_valid()) return false;
  const bool levels = black_level <= brightness.dark_level && target_level > brightness.dark_level &&
                      target_level < ceiling_level && ceiling_level < vision::saturated_level;
  const bool factors = lies_in(dead_band, 1.0, most_factor) && dead_band > 1.0 &&
                       lies_in(max_step, dead_band, most_factor) && min_bright_samples >= 1 && dark_frames >= 1;
  const bool times = exposure_min.ns > 0 && exposure_min <= exposure_start && exposure_start <= exposure_max &&
                     exposure_max.ns <= most_exposure_ns;
  return levels && factors && times && lies_in(gain_min, 1.0 / most_gain, most_gain) &&
         lies_in(gain_max, gain_min, most_gain);
}

void AutoExposure::configure(const AutoExposureConfig& config) {
  config_ = config;
  wanted_ = applied_ = {};
  has_applied_ = false;
  to_settle_ = 0;
  dark_in_a_row_ = 0;
}

ExposureReport AutoExposure::serve(const vision::Brightness* brightness) {
  ExposureReport report;
  report.exposure = applied_;
  if (brightness != nullptr) {
    report.measured = true;
    report.brightness = *brightness;
    if (to_settle_ > 0) {
      --to_settle_;
      return report;
    }
  }
  if (!has_applied_) {
    // Not held against frames: after a failure the next attempt is due with the next frame that counts.
    if (brightness != nullptr) command(static_cast<double>(config_.exposure_start.ns) * config_.gain_min, report);
    return report;
  }
  if (brightness == nullptr) return report;
  report.judged = true;
  report.dark = is_dark(*brightness);
  if (report.dark) {
    increment(dark_in_a_row_);
    if (config_.when_dark == DarkAction::hold || dark_in_a_row_ < config_.dark_frames) return report;
  } else {
    dark_in_a_row_ = 0;
  }
  const double factor = report.dark ? config_.max_step : correction(*brightness);
  if (factor < config_.dead_band && factor * config_.dead_band > 1.0) return report;
  command(product_of(applied_) * factor, report);
  return report;
}

bool AutoExposure::is_dark(const vision::Brightness& brightness) const {
  return brightness.bright < config_.min_bright_samples || brightness.level <= config_.brightness.dark_level;
}

double AutoExposure::correction(const vision::Brightness& brightness) const {
  if (brightness.level >= vision::saturated_level) return 1.0 / config_.max_step;
  const auto factor_to = [this](std::uint8_t wanted, std::uint8_t seen) {
    const int light = std::max(seen - config_.black_level, 1);
    return static_cast<double>(wanted - config_.black_level) / light;
  };
  double factor = factor_to(config_.target_level, brightness.level);
  const bool over = brightness.peak_level >= vision::saturated_level;
  factor = std::min(factor, over ? 1.0 / step_down : factor_to(config_.ceiling_level, brightness.peak_level));
  return std::clamp(factor, 1.0 / config_.max_step, config_.max_step);
}

Status AutoExposure::usable_limits(hal::ExposureLimits& limits) const {
  const Status status = control_->limits(limits);
  if (status != Status::ok) return status;
  // Where ours and the device's have nothing in common the nearest that the device can do is taken.
  const auto narrow = [](auto& low, auto& high, auto our_low, auto our_high) {
    const auto least = std::clamp(our_low, low, high);
    high = std::clamp(our_high, low, high);
    low = least;
  };
  narrow(limits.time_min, limits.time_max, config_.exposure_min, config_.exposure_max);
  narrow(limits.gain_min, limits.gain_max, config_.gain_min, config_.gain_max);
  return Status::ok;
}

hal::Exposure AutoExposure::share_out(double product, const hal::ExposureLimits& limits) {
  hal::Exposure out;
  out.time = clamped_time(product / limits.gain_min, limits);
  out.gain = std::clamp(product / static_cast<double>(out.time.ns), limits.gain_min, limits.gain_max);
  return out;
}

bool AutoExposure::is_near(double product, double wanted) const {
  return product < wanted * config_.dead_band && product * config_.dead_band > wanted;
}

void AutoExposure::command(double product, ExposureReport& report) {
  hal::ExposureLimits limits;
  Status status = usable_limits(limits);
  if (status == Status::ok) {
    hal::Exposure wanted = share_out(product, limits);
    if (has_applied_ && wanted == wanted_) return;  // at a limit, or between two steps of the device
    const hal::Exposure before = applied_;
    const bool had_applied = has_applied_;
    status = apply(wanted);
    if (status == Status::ok && !is_near(product_of(applied_), product)) status = make_up(product, wanted, limits);
    report.changed = has_applied_ && (!had_applied || !(applied_ == before));
    report.exposure = applied_;
    if (status == Status::ok) wanted_ = share_out(product, limits);
  }
  report.status = status;
  // Not sooner after a failure either: a device that does not answer is not asked with each frame.
  if (report.changed || status != Status::ok) to_settle_ = config_.settle_frames;
}

Status AutoExposure::make_up(double product, const hal::Exposure& wanted, const hal::ExposureLimits& limits) {
  hal::Exposure next = wanted;
  if (is_near(applied_.gain, wanted.gain)) {
    next.time = applied_.time;
    next.gain = std::clamp(product / static_cast<double>(applied_.time.ns), limits.gain_min, limits.gain_max);
    return next == applied_ ? Status::ok : apply(next);
  }
  if (applied_.gain < wanted.gain) {  // time that is at its most can only make up for too much
    next.gain = std::min(wanted.gain * wanted.gain / applied_.gain, limits.gain_max);
    if (const Status status = apply(next); status != Status::ok) return status;
  }
  next.gain = applied_.gain;
  next.time = clamped_time(product / applied_.gain, limits);
  return next == applied_ ? Status::ok : apply(next);
}

Status AutoExposure::apply(const hal::Exposure& wanted) {
  hal::Exposure applied;
  const Status status = control_->set(wanted, applied);
  if (status != Status::ok) return status;
  applied_ = applied;
  has_applied_ = true;
  return Status::ok;
}

}  // namespace relnav::app
