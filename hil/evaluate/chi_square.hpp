#pragma once

namespace relnav::hil {

/// P(X <= x) of the chi-square distribution (regularised incomplete gamma function: series below, continued fraction above).
[[nodiscard]] double chi_square_cdf(double x, double degrees_of_freedom);
/// x with P(X <= x) = probability, 0 < probability < 1.
[[nodiscard]] double chi_square_quantile(double probability, double degrees_of_freedom);

}  // namespace relnav::hil
