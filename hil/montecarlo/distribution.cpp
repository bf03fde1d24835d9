#include "hil/montecarlo/distribution.hpp"

#include <algorithm>
#include <cmath>

namespace relnav::hil {
namespace {

constexpr std::size_t histogram_bins = 40;

double order_statistic(const std::vector<double>& sorted, double share) {
  const double place = share * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(place);
  if (below + 1 >= sorted.size()) return sorted.back();
  return sorted[below] + (place - static_cast<double>(below)) * (sorted[below + 1] - sorted[below]);
}

Histogram histogram_of(const std::vector<double>& sorted, double quartile_1, double quartile_3) {
  constexpr double reach = 3.0;
  const double distance = reach * (quartile_3 - quartile_1);
  Histogram h;
  h.low = std::max(sorted.front(), quartile_1 - distance);
  h.high = std::min(sorted.back(), quartile_3 + distance);
  h.counts.assign(h.high > h.low ? histogram_bins : 1, 0);
  const double bins = static_cast<double>(h.counts.size());
  for (const double value : sorted) {
    if (value < h.low) {
      ++h.below;
    } else if (value > h.high) {
      ++h.above;
    } else {
      const double place = h.high > h.low ? (value - h.low) / (h.high - h.low) * bins : 0.0;
      ++h.counts[std::min(static_cast<std::size_t>(place), h.counts.size() - 1)];
    }
  }
  return h;
}

}  // namespace

void Moments::add(double value) {
  min_ = count_ == 0 ? value : std::min(min_, value);
  max_ = count_ == 0 ? value : std::max(max_, value);
  ++count_;
  const double before = value - mean_;
  mean_ += before / static_cast<double>(count_);
  squares_ += before * (value - mean_);
}

double Moments::sd() const { return count_ > 1 ? std::sqrt(squares_ / static_cast<double>(count_ - 1)) : 0.0; }

Distribution distribution_of(std::vector<double> values) {
  Distribution d;
  if (values.empty()) return d;
  for (const double value : values) d.moments.add(value);
  std::sort(values.begin(), values.end());
  for (std::size_t k = 0; k < percentile_points.size(); ++k) {
    d.percentiles[k] = order_statistic(values, percentile_points[k] / 100.0);
  }
  d.histogram = histogram_of(values, order_statistic(values, 0.25), order_statistic(values, 0.75));
  return d;
}

std::pair<double, double> wilson_95(std::uint64_t hits, std::uint64_t count) {
  if (count == 0) return {0.0, 1.0};
  constexpr double z = 1.959963984540054;
  const double n = static_cast<double>(count);
  const double share = static_cast<double>(hits) / n;
  const double middle = share + z * z / (2.0 * n);
  const double half = z * std::sqrt(share * (1.0 - share) / n + z * z / (4.0 * n * n));
  const double scale = 1.0 + z * z / n;
  return {hits == 0 ? 0.0 : (middle - half) / scale, hits == count ? 1.0 : (middle + half) / scale};
}

}  // namespace relnav::hil
