#pragma once
#include <cmath>

#include "fsw/base/generator.hpp"
#include "fsw/math/types.hpp"

namespace relnav::hil {

/// Standard normal numbers from the project's seeded generator (polar method: Marsaglia, Bray, SIAM Review 6(3), 1964).
class Gaussian {
 public:
  explicit Gaussian(std::uint64_t seed) : generator_(seed) {}

  double next() {
    for (;;) {  // one pass in 1.27 on average
      const double x = 2.0 * generator_.uniform() - 1.0;
      const double y = 2.0 * generator_.uniform() - 1.0;
      const double s = x * x + y * y;
      if (s > 0.0 && s < 1.0) return x * std::sqrt(-2.0 * std::log(s) / s);
    }
  }
  /// Evenly distributed over all directions.
  Vec3 direction() {
    for (;;) {
      const double x = next();
      const double y = next();
      const double z = next();
      const Vec3 v(x, y, z);
      if (v.norm() > 1e-3) return v.normalized();
    }
  }
  double uniform(double low, double high) { return low + (high - low) * generator_.uniform(); }

 private:
  Generator generator_;
};

}  // namespace relnav::hil
