#pragma once

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

}  // namespace relnav
