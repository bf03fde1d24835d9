#pragma once
#include <cstdint>

#include "fsw/math/fixed.hpp"

namespace relnav {

/// What a solver in a given scalar needs to know of it. gain, least_rate, step, cost_slack, least_pivot: as in
/// IterationLimits, gain in squared sigmas; least_gain: not under this once the rows are scaled. least_gap: under which
/// directions count as parallel, see RotorEquations.
template <typename S>
struct ScalarTraits;

template <>
struct ScalarTraits<double> {
  static constexpr double gain = 1e-13;
  static constexpr double least_gain = 0.0;
  static constexpr double least_rate = 1e-5;
  static constexpr double step = 1e-13;
  static constexpr double cost_slack = 1e-12;
  static constexpr double least_pivot = 1e-13;
  static constexpr double least_gap = 1e-9;
};
template <>
struct ScalarTraits<float> {
  static constexpr double gain = 1e-7;
  static constexpr double least_gain = 0.0;
  static constexpr double least_rate = 1e-5;
  static constexpr double step = 2e-6;
  static constexpr double cost_slack = 1e-5;
  static constexpr double least_pivot = 2e-7;
  static constexpr double least_gap = 1e-5;
};
/// Of 64 bits.
template <int FractionBits>
struct ScalarTraits<Fixed<FractionBits>> {
  static constexpr double gain = 1e-10;
  static constexpr double least_gain = 4.0 / static_cast<double>(std::int64_t{1} << FractionBits);
  static constexpr double least_rate = 1.0;  // products of two small gains are lost to rounding
  static constexpr double step = 1e-11;
  static constexpr double cost_slack = 1e-10;
  static constexpr double least_pivot = 1e-11;
  static constexpr double least_gap = 1e-9;
};

}  // namespace relnav
