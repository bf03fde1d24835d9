#pragma once
#include <cmath>

namespace relnav {

/// 99 % point of the chi-square distribution, k >= 1 degrees of freedom, by Wilson and Hilferty, PNAS 17(12), 1931:
/// k (1 - 2/(9k) + z sqrt(2/(9k)))^3, z = 2.3263. Error under 1 % for k >= 2.
[[nodiscard]] inline double chi2_99(int k) {
  const double n = static_cast<double>(k);
  const double v = 2.0 / (9.0 * n);
  const double c = 1.0 - v + 2.326347874 * std::sqrt(v);
  return n * c * c * c;
}

}  // namespace relnav
