#include "platform/linux/stream_exposure.hpp"

#include <algorithm>
#include <cmath>

namespace relnav::platform::linux {
namespace {

constexpr double ns_per_us = 1e3;

}  // namespace

double StreamExposure::factor_of(double gain) const {
  return unit_.kind == GainUnit::Kind::decibel ? std::pow(10.0, gain * unit_.step / 20.0) : gain * unit_.step;
}

double StreamExposure::gain_of(double factor) const {
  const double gain =
      unit_.kind == GainUnit::Kind::decibel ? 20.0 * std::log10(factor) / unit_.step : factor / unit_.step;
  constexpr double digits =
      1e9;  // there and back it is the same number: some cameras cut off what comes after the point
  return std::round(gain * digits) / digits;
}

Status StreamExposure::limits(hal::ExposureLimits& limits) {
  ExposureRange range;
  const Status status = camera_.exposure_range(range);
  if (status != Status::ok) return status;
  // Inwards: what is offered in whole nanoseconds is not refused by the device.
  const Duration time_min{std::max<std::int64_t>(static_cast<std::int64_t>(std::ceil(range.least_us * ns_per_us)), 1)};
  const Duration time_max{static_cast<std::int64_t>(std::floor(range.most_us * ns_per_us))};
  double gain_min = 1.0;
  double gain_max = 1.0;
  if (range.has_gain) {
    gain_min = factor_of(range.gain_least);
    gain_max = factor_of(range.gain_most);
    if (unit_.kind == GainUnit::Kind::linear) gain_min = std::max(gain_min, unit_.step);
  }
  if (time_min > time_max || !(gain_min > 0.0) || !(gain_min <= gain_max) || !std::isfinite(gain_max)) {
    return Status::unsupported;
  }
  limits = {time_min, time_max, gain_min, gain_max};
  return Status::ok;
}

Status StreamExposure::set(const hal::Exposure& wanted, hal::Exposure& applied) {
  hal::ExposureLimits inside;
  const Status status = limits(inside);
  if (status != Status::ok) return status;
  const bool is_inside = wanted.time >= inside.time_min && wanted.time <= inside.time_max &&
                         wanted.gain >= inside.gain_min && wanted.gain <= inside.gain_max;
  if (!is_inside) return Status::invalid_argument;
  ExposureRange range;
  if (const Status known = camera_.exposure_range(range); known != Status::ok) return known;
  ExposureValues values;
  values.exposure_us = std::clamp(static_cast<double>(wanted.time.ns) / ns_per_us, range.least_us, range.most_us);
  if (range.has_gain) values.gain = std::clamp(gain_of(wanted.gain), range.gain_least, range.gain_most);
  if (const Status set = camera_.adjust(values); set != Status::ok) return set;
  hal::Exposure out;
  out.time.ns = std::clamp(std::llround(values.exposure_us * ns_per_us), static_cast<long long>(inside.time_min.ns),
                           static_cast<long long>(inside.time_max.ns));
  if (range.has_gain) out.gain = std::clamp(factor_of(values.gain), inside.gain_min, inside.gain_max);
  applied = out;
  return Status::ok;
}

}  // namespace relnav::platform::linux
