#pragma once
#include <array>
#include <cstdint>
#include <utility>
#include <vector>

namespace relnav::hil {

/// Mean and spread of values one by one, in constant memory (Welford).
class Moments {
 public:
  void add(double value);
  [[nodiscard]] std::uint64_t count() const { return count_; }
  [[nodiscard]] double mean() const { return mean_; }
  /// Of a sample (n - 1); 0 below two values.
  [[nodiscard]] double sd() const;
  [[nodiscard]] double min() const { return min_; }
  [[nodiscard]] double max() const { return max_; }

 private:
  std::uint64_t count_ = 0;
  double mean_ = 0.0;
  double squares_ = 0.0;
  double min_ = 0.0;
  double max_ = 0.0;
};

inline constexpr std::array<int, 7> percentile_points{1, 5, 25, 50, 75, 95, 99};

struct Histogram {
  double low = 0.0;
  double high = 0.0;
  std::uint64_t below = 0;  ///< values beyond the ends, kept out so that a few do not squeeze the rest into one bin
  std::uint64_t above = 0;
  std::vector<std::uint64_t> counts;  ///< equal bins from low to high; both ends belong to the outer bins
};

struct Distribution {
  Moments moments;
  std::array<double, percentile_points.size()> percentiles{};  ///< between order statistics linearly
  Histogram histogram;  ///< from the quartiles three times their distance outwards, where there are values
};

/// Of finite values. The mean is summed up in the order they are in.
[[nodiscard]] Distribution distribution_of(std::vector<double> values);

/// Wilson's interval of a share, 95 %.
[[nodiscard]] std::pair<double, double> wilson_95(std::uint64_t hits, std::uint64_t count);

}  // namespace relnav::hil
