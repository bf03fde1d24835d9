#include "hil/evaluate/chi_square.hpp"

#include <algorithm>
#include <cmath>

namespace relnav::hil {
namespace {

constexpr int max_terms = 100000;
constexpr double relative_tolerance = 1e-15;

double gamma_series(double a, double x) {
  double term = 1.0 / a;
  double sum = term;
  for (int n = 1; n < max_terms && term > sum * relative_tolerance; ++n) {
    term *= x / (a + n);
    sum += term;
  }
  return sum * std::exp(-x + a * std::log(x) - std::lgamma(a));
}

// Complement, by the continued fraction (modified Lentz).
double gamma_fraction(double a, double x) {
  constexpr double tiny = 1e-300;
  double b = x + 1.0 - a;
  double c = 1.0 / tiny;
  double d = 1.0 / b;
  double h = d;
  for (int n = 1; n < max_terms; ++n) {
    const double an = -n * (n - a);
    b += 2.0;
    d = an * d + b;
    if (std::abs(d) < tiny) d = tiny;
    c = b + an / c;
    if (std::abs(c) < tiny) c = tiny;
    d = 1.0 / d;
    const double factor = d * c;
    h *= factor;
    if (std::abs(factor - 1.0) < relative_tolerance) break;
  }
  return h * std::exp(-x + a * std::log(x) - std::lgamma(a));
}

}  // namespace

double chi_square_cdf(double x, double degrees_of_freedom) {
  if (!(x > 0.0)) return 0.0;
  const double a = 0.5 * degrees_of_freedom;
  const double half = 0.5 * x;
  return half < a + 1.0 ? gamma_series(a, half) : 1.0 - gamma_fraction(a, half);
}

double chi_square_quantile(double probability, double degrees_of_freedom) {
  double low = 0.0;
  double high = std::max(1.0, degrees_of_freedom);
  while (chi_square_cdf(high, degrees_of_freedom) < probability) high *= 2.0;
  for (int i = 0; i < 200 && high - low > 1e-13 * high; ++i) {
    const double middle = 0.5 * (low + high);
    (chi_square_cdf(middle, degrees_of_freedom) < probability ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace relnav::hil
