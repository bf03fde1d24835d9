#pragma once
#include <cmath>

#include "fsw/base/generator.hpp"
#include "fsw/math/types.hpp"

namespace relnav::test {

/// Normally distributed numbers from the project's generator (Box-Muller; test code may use the standard library).
class Normal {
 public:
  explicit Normal(std::uint64_t seed) : generator_(seed, 77) {}
  double operator()() {
    const double u = (generator_.next() + 1.0) * 0x1p-32;
    const double v = generator_.uniform();
    return std::sqrt(-2.0 * std::log(u)) * std::cos(6.283185307179586 * v);
  }
  Vec3 vec3() {
    const double x = (*this)();
    const double y = (*this)();
    const double z = (*this)();
    return {x, y, z};
  }
  // The order of the draws is ours: that of a call's arguments is each compiler's own, and other samples on each target.
  Vec2 vec2() {
    const double y = (*this)();
    const double x = (*this)();
    return {x, y};
  }
  /// (x, y, 1), x and y evenly within half of `width` from zero.
  Vec3 ahead(double width) {
    const double y = width * (generator_.uniform() - 0.5);
    const double x = width * (generator_.uniform() - 0.5);
    return {x, y, 1.0};
  }
  Generator& generator() { return generator_; }

 private:
  Generator generator_;
};

}  // namespace relnav::test
