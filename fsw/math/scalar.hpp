#pragma once
#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Core>

#include "fsw/math/fixed.hpp"

namespace relnav {

// What code for any scalar asks of it.

/// False of NaN, infinity, and a Fixed that has overflowed: what is computed from it means nothing, Status::not_finite.
[[nodiscard]] inline bool is_sound(double value) { return std::isfinite(value); }
[[nodiscard]] inline bool is_sound(float value) { return std::isfinite(value); }
template <int FractionBits, typename Raw>
[[nodiscard]] constexpr bool is_sound(const Fixed<FractionBits, Raw>& value) {
  return !value.overflowed();
}
template <typename S, int Rows, int Cols>
[[nodiscard]] bool is_sound(const Eigen::Matrix<S, Rows, Cols>& values) {
  for (Eigen::Index c = 0; c < Cols; ++c) {
    for (Eigen::Index r = 0; r < Rows; ++r) {
      if (!is_sound(values(r, c))) return false;
    }
  }
  return true;
}

/// Smallest positive number, to a step, whose inverse is in range; 0 in floating point, where that is no concern.
template <typename S>
struct LeastDivisor {
  static constexpr S value = S(0);
};
template <int FractionBits, typename Raw>
struct LeastDivisor<Fixed<FractionBits, Raw>> {
  static constexpr int place = std::max(2 * FractionBits - std::numeric_limits<Raw>::digits, 0);
  static constexpr auto value = Fixed<FractionBits, Raw>::from_raw((Raw{1} << place) + 1);
};

}  // namespace relnav
