#pragma once

namespace relnav::math {

// Elementary functions with the same bits on every target: only + - * / sqrt, in a fixed order, on binary64.
// Errors are the maxima measured by tests/unit/math/elementary_test.cpp, in units of the last place of the result.
// NaN gives NaN, a signed zero keeps its sign where the function is odd. No tables, no state; errno is not used.
// Method: Muller, Elementary Functions, 3rd ed..

/// Largest |angle| the circular functions accept, rad (2^20). Beyond it, and for infinities, they return NaN:
/// an angle of 160 000 turns is a bug, not a measurement.
inline constexpr double max_angle = 1048576.0;

struct SinCos {
  double sin = 0.0;
  double cos = 1.0;
};

/// Radians, |x| <= max_angle. Error <= 1 ulp.
[[nodiscard]] double sin(double x);
[[nodiscard]] double cos(double x);
/// Bits equal to sin(x), cos(x); one range reduction.
[[nodiscard]] SinCos sincos(double x);
/// Error <= 2 ulp.
[[nodiscard]] double tan(double x);

/// In [-pi/2, pi/2]. Error <= 1 ulp.
[[nodiscard]] double atan(double x);
/// Angle of the point (x, y), in [-pi, pi]; zeros and infinities as in ISO C F.10.1.4. Error <= 2 ulp.
[[nodiscard]] double atan2(double y, double x);
/// |x| <= 1, else NaN. Error <= 2 ulp.
[[nodiscard]] double asin(double x);
[[nodiscard]] double acos(double x);

/// 0 below -745.14, infinity above 709.79. Error <= 1 ulp, also for a subnormal result.
[[nodiscard]] double exp(double x);
/// log(0) = -infinity, NaN for x < 0. Error <= 1 ulp.
[[nodiscard]] double log(double x);

}  // namespace relnav::math
