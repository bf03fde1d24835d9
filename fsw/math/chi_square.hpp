#pragma once
#include <cmath>

namespace relnav {

/// Point of the chi-square distribution, k >= 1 degrees of freedom, that is passed as often as z by a standard normal, by
/// Wilson and Hilferty, PNAS 17(12), 1931: k (1 - 2/(9k) + z sqrt(2/(9k)))^3. For z from 0 to 2.4 within 1.4 % (k = 2), 0.5 %
/// (k >= 4); up to z = 5 within 11 % and 6.5 %, on the large side there.
[[nodiscard]] inline double chi2_point(int k, double z) {
  const double n = static_cast<double>(k);
  const double v = 2.0 / (9.0 * n);
  const double c = 1.0 - v + z * std::sqrt(v);
  return n * c * c * c;
}

/// 99 % point: z = 2.3263.
[[nodiscard]] inline double chi2_99(int k) { return chi2_point(k, 2.326347874); }

}  // namespace relnav
