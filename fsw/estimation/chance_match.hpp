#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

#include "fsw/config.hpp"

namespace relnav {

/// Probability that at least k of n independent trials succeed, each with probability p in [0, 1]. n <= 1000.
[[nodiscard]] inline double binomial_tail(int n, int k, double p) {
  if (k <= 0) return 1.0;
  if (k > n || !(p > 0.0)) return 0.0;
  if (p >= 1.0) return 1.0;
  // Term i = k, then by the ratio of neighbours; all terms are positive.
  double term = 1.0;
  for (int i = 0; i < k; ++i) term *= p * static_cast<double>(n - i) / static_cast<double>(i + 1);
  for (int i = 0; i < n - k; ++i) term *= 1.0 - p;
  double sum = 0.0;
  for (int i = k; i <= n; ++i) {
    sum += term;
    term *= p / (1.0 - p) * static_cast<double>(n - i) / static_cast<double>(i + 1);
  }
  return sum < 1.0 ? sum : 1.0;
}

/// Number of successes of independent trials, each with its own probability.
class ChanceCount {
 public:
  void add(double p) {
    if (count_ < p_.size()) p_[count_++] = std::clamp(p, 0.0, 1.0);
  }
  /// Probability that at least k of the trials succeed, those with the `left_out` smallest probabilities left out.
  [[nodiscard]] double tail(std::size_t left_out, int k) {
    if (k <= 0) return 1.0;
    for (std::size_t i = 1; i < count_; ++i) {
      for (std::size_t j = i; j > 0 && p_[j] < p_[j - 1]; --j) std::swap(p_[j], p_[j - 1]);
    }
    const auto least = static_cast<std::size_t>(k);
    if (count_ < left_out + least) return 0.0;
    // below[j]: probability of j successes so far; the last one collects all from k on.
    std::array<double, config::max_observations + 1> below{};
    below[0] = 1.0;
    for (std::size_t i = left_out; i < count_; ++i) {
      below[least] += p_[i] * below[least - 1];
      for (std::size_t j = least; j-- > 1;) below[j] = (1.0 - p_[i]) * below[j] + p_[i] * below[j - 1];
      below[0] *= 1.0 - p_[i];
    }
    return below[least];
  }

 private:
  std::array<double, config::max_observations> p_{};
  std::size_t count_ = 0;
};

}  // namespace relnav
