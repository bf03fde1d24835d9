#include "fsw/math/elementary.hpp"

#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace relnav::math {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();

// A constant as the sum of a double and what that double leaves over.
struct Sum {
  double head;
  double tail;
};
constexpr Sum pi = {0x1.921fb54442d18p+1, 0x1.1a62633145c07p-53};
constexpr Sum half_pi = {0x1.921fb54442d18p+0, 0x1.1a62633145c07p-54};

constexpr double magnitude(double x) {
  return std::bit_cast<double>(std::bit_cast<std::uint64_t>(x) & 0x7FFFFFFFFFFFFFFFULL);
}
constexpr bool is_negative(double x) { return (std::bit_cast<std::uint64_t>(x) >> 63U) != 0; }
constexpr double with_sign(double positive, bool negative) { return negative ? -positive : positive; }
constexpr bool is_nan(double x) { return !(x <= 0.0) && !(x > 0.0); }
constexpr bool is_infinite(double x) { return magnitude(x) >= infinity; }
/// 2^e, e in [-1022, 1023].
constexpr double power_of_two(int e) { return std::bit_cast<double>(static_cast<std::uint64_t>(e + 1023) << 52U); }

/// c[0] + c[1] z + ... by Horner's rule.
template <std::size_t N>
[[gnu::always_inline]] inline double polynomial(const double (&c)[N], double z) {
  double sum = c[N - 1];
  for (std::size_t i = N - 1; i > 0; --i) sum = sum * z + c[i - 1];
  return sum;
}

// ---- circular functions -------------------------------------------------------------------------------------------

/// x = quadrant pi/2 + (head + tail), |head| <= pi/4.
struct Reduced {
  double head;
  double tail;
  int quadrant;  // modulo 4
};

constexpr double small_angle = 0x1p-27;  // x^2 / 6 < ulp / 2: sin x = x and cos x = 1

/// Cody and Waite, Software Manual for the Elementary Functions (1980), with four parts.
/// pi/2 = three parts of 33 bits and the rest: n < 2^20 times a part is exact, and so is the difference to the first.
/// No double below 2^20 lies nearer to a multiple of pi/2 than 2^-61; the parts leave an error below 2^-130.
Reduced reduce(double x) {
  constexpr double part[4] = {0x1.921fb544p+0, 0x1.0b4611a6p-34, 0x1.3198a2ep-69, 0x1.b839a252049c1p-104};
  constexpr double two_over_pi = 0x1.45f306dc9c883p-1;
  const std::int32_t n = static_cast<std::int32_t>(x * two_over_pi + (x < 0.0 ? -0.5 : 0.5));
  if (n == 0) return {x, 0.0, 0};
  const double count = static_cast<double>(n);
  const double a = x - count * part[0];
  // Two differences with their rounding errors (Knuth's two-sum: a may be the smaller).
  const double b_exact = count * part[1];
  const double b = a - b_exact;
  const double b_back = b - a;
  const double b_error = (a - (b - b_back)) - (b_exact + b_back);
  const double c_exact = count * part[2];
  const double c = b - c_exact;
  const double c_back = c - b;
  const double c_error = (b - (c - c_back)) - (c_exact + c_back);
  const double low = (b_error + c_error) - count * part[3];
  const double head = c + low;
  return {head, (c - head) + low, static_cast<int>(static_cast<std::uint32_t>(n) & 3U)};
}

/// sin(head + tail) as the sum of two, |head| <= pi/4 (and a little). Taylor to x^17; the next term is below 1e-19.
Sum sin_kernel(double head, double tail) {
  constexpr double c[] = {-1.0 / 6.0,        1.0 / 120.0,        -1.0 / 5040.0,          1.0 / 362880.0,
                          -1.0 / 39916800.0, 1.0 / 6227020800.0, -1.0 / 1307674368000.0, 1.0 / 355687428096000.0};
  if (magnitude(head) < small_angle) return {head, -0.0};  // -0 - 0 = -0
  const double z = head * head;
  return {head, head * (z * polynomial(c, z)) + tail * (1.0 - 0.5 * z)};
}

/// cos(head + tail) as the sum of two. Taylor to x^16; the rounding error of 1 - x^2/2 is added back.
Sum cos_kernel(double head, double tail) {
  constexpr double c[] = {1.0 / 24.0,        -1.0 / 720.0,         1.0 / 40320.0,         -1.0 / 3628800.0,
                          1.0 / 479001600.0, -1.0 / 87178291200.0, 1.0 / 20922789888000.0};
  const double z = head * head;
  const double half = 0.5 * z;
  const double top = 1.0 - half;
  return {top, ((1.0 - top) - half) + (z * (z * polynomial(c, z)) - head * tail)};
}

// ---- inverse functions --------------------------------------------------------------------------------------------

/// (1 - atan(t) / t) / t^2 in z = t^2 on [0, 0.162]: interpolated at Chebyshev nodes; relative error of atan 2.6e-18.
double atan_series(double z) {
  constexpr double c[] = {0x1.5555555555555p-2, -0x1.99999999995e4p-3, 0x1.2492492458e13p-3, -0x1.c71c719babbd6p-4,
                          0x1.745d0ed0fcf5ep-4, -0x1.3b12ba5767ae9p-4, 0x1.10ff67f17703p-4,  -0x1.e03e813b3bc5ap-5,
                          0x1.a27461a5eb784p-5, -0x1.46e5ba7ed6e1ap-5, 0x1.4815de3320503p-6};
  return z * polynomial(c, z);
}

/// (asin(t) / t - 1) in z = t^2 on [0, 0.25]: interpolated at Chebyshev nodes; relative error of asin 5.4e-18.
double asin_series(double z) {
  constexpr double c[] = {0x1.5555555555556p-3, 0x1.3333333332ecap-4, 0x1.6db6db6e31f13p-5, 0x1.f1c71c1db0623p-6,
                          0x1.6e8bb1c8209a2p-6, 0x1.1c4d35cf95421p-6, 0x1.c9cf07674736ap-7, 0x1.782651caa6547p-7,
                          0x1.52420b04b37bep-7, 0x1.65a9c4dfcf8b2p-8, 0x1.1d189408314eep-6, -0x1.e6aaa8a0a04ccp-7,
                          0x1.d72b2bc8155f8p-6};
  return z * polynomial(c, z);
}

/// atan of x >= 0 as head + tail, |tail| <= ulp(head): atan x = atan c + atan((x - c) / (1 + c x)), |t| <= 0.4.
Sum atan_positive(double x) {
  Sum base = {0.0, 0.0};
  double t = x;
  if (x >= 2.5) {
    base = half_pi;
    t = -1.0 / x;
  } else if (x >= 1.25) {
    base = {0x1.0d38f2c5ba09fp+0, -0x1.bd0dc231bfd7p-54};  // atan 1.75
    t = (x - 1.75) / (1.0 + 1.75 * x);
  } else if (x >= 0.75) {
    base = {0x1.921fb54442d18p-1, 0x1.1a62633145c07p-55};  // atan 1
    t = (x - 1.0) / (1.0 + x);
  } else if (x >= 0.4) {
    base = {0x1.dac670561bb4fp-2, 0x1.a2b7f222f65e2p-56};  // atan 0.5
    t = (x - 0.5) / (1.0 + 0.5 * x);
  } else if (x < 0x1p-28) {
    return {x, 0.0};
  }
  const double correction = base.tail - t * atan_series(t * t);
  if (x < 0.4) return {t, correction};
  const double head = base.head + t;
  return {head, ((base.head - head) + t) + correction};
}

/// asin(sqrt(w)) as head + tail for w in (0, 0.25]; head has 21 significant bits.
Sum asin_of_root(double w) {
  const double root = std::sqrt(w);
  const double head = std::bit_cast<double>(std::bit_cast<std::uint64_t>(root) & 0xFFFFFFFF00000000ULL);
  const double rest = (w - head * head) / (root + head);  // sqrt(w) - head, head^2 exact
  return {head, rest + root * asin_series(w)};
}

/// value - 2 part
double minus_twice(Sum value, Sum part) {
  const double twice = 2.0 * part.head;
  const double difference = value.head - twice;
  const double error = (value.head - difference) - twice;
  return difference + (error + (value.tail - 2.0 * part.tail));
}

}  // namespace

double sin(double x) { return sincos(x).sin; }

double cos(double x) { return sincos(x).cos; }

SinCos sincos(double x) {
  if (!(magnitude(x) <= max_angle)) return {nan, nan};
  const Reduced r = reduce(x);
  const Sum sin_sum = sin_kernel(r.head, r.tail);
  const Sum cos_sum = cos_kernel(r.head, r.tail);
  const double s = sin_sum.head + sin_sum.tail;
  const double c = cos_sum.head + cos_sum.tail;
  switch (r.quadrant) {
    case 0: return {s, c};
    case 1: return {c, -s};
    case 2: return {-s, -c};
    default: return {-c, s};
  }
}

double tan(double x) {
  if (!(magnitude(x) <= max_angle)) return nan;
  if (magnitude(x) < small_angle) return x;
  const Reduced r = reduce(x);
  Sum above = sin_kernel(r.head, r.tail);
  Sum below = cos_kernel(r.head, r.tail);
  if ((r.quadrant & 1) != 0) {
    const Sum s = above;
    above = below;
    below = {-s.head, -s.tail};
  }
  // What rounding took from numerator and denominator corrects the quotient to first order: 1.4 ulp instead of 2.2.
  const double a = above.head + above.tail;
  const double b = below.head + below.tail;
  const double quotient = a / b;
  const double a_error = (above.head - a) + above.tail;
  const double b_error = (below.head - b) + below.tail;
  return quotient + (a_error - quotient * b_error) / b;
}

double atan(double x) {
  if (is_nan(x)) return nan;
  const Sum a = atan_positive(magnitude(x));
  return with_sign(a.head + a.tail, is_negative(x));
}

double atan2(double y, double x) {
  if (is_nan(x) || is_nan(y)) return nan;
  const double rise = magnitude(y);
  const double run = magnitude(x);
  double ratio = 0.0;
  if (is_infinite(rise) && is_infinite(run)) {
    ratio = 1.0;
  } else if (rise > 0.0) {
    ratio = rise / run;  // overflow and underflow give the limits wanted
  }
  Sum a = atan_positive(ratio);
  if (is_negative(x)) {
    const double head = pi.head - a.head;
    a = {head, ((pi.head - head) - a.head) + (pi.tail - a.tail)};
  }
  return with_sign(a.head + a.tail, is_negative(y));
}

double asin(double x) {
  const double t = magnitude(x);
  if (!(t <= 1.0)) return nan;
  if (t < 0x1p-28) return x;
  if (t <= 0.5) return x + x * asin_series(x * x);
  if (t >= 1.0) return with_sign(half_pi.head, is_negative(x));
  // asin t = pi/2 - 2 asin sqrt((1 - t) / 2); 1 - t is exact
  return with_sign(minus_twice(half_pi, asin_of_root(0.5 * (1.0 - t))), is_negative(x));
}

double acos(double x) {
  const double t = magnitude(x);
  if (!(t <= 1.0)) return nan;
  if (t <= 0.5) {
    const double head = half_pi.head - x;
    const double error = (half_pi.head - head) - x;
    return head + (error + (half_pi.tail - x * asin_series(x * x)));
  }
  if (t >= 1.0) return is_negative(x) ? pi.head : 0.0;
  const Sum half = asin_of_root(0.5 * (1.0 - t));
  if (is_negative(x)) return minus_twice(pi, half);
  return 2.0 * (half.head + half.tail);
}

/// exp x = 2^k exp r, |r| <= ln 2 / 2; Taylor to r^13, the next term is below 5e-18.
double exp(double x) {
  constexpr double c[] = {1.0 / 2.0,       1.0 / 6.0,        1.0 / 24.0,        1.0 / 120.0,
                          1.0 / 720.0,     1.0 / 5040.0,     1.0 / 40320.0,     1.0 / 362880.0,
                          1.0 / 3628800.0, 1.0 / 39916800.0, 1.0 / 479001600.0, 1.0 / 6227020800.0};
  constexpr double inverse_ln2 = 0x1.71547652b82fep+0;
  constexpr Sum ln2 = {0x1.62e42fefa38p-1, 0x1.ef35793c7673p-45};  // head of 42 bits: k head is exact
  if (is_nan(x)) return nan;
  if (x > 710.0) return infinity;
  if (x < -746.0) return 0.0;
  const int k = static_cast<int>(x * inverse_ln2 + (x < 0.0 ? -0.5 : 0.5));
  const double count = static_cast<double>(k);
  const double high = x - count * ln2.head;
  const double low = count * ln2.tail;
  const double r = high - low;
  const double r_error = (high - r) - low;
  const double top = 1.0 + r;
  const double top_error = (1.0 - top) + r;
  const double y = top + (top_error + (r_error + r * r * polynomial(c, r)));
  // In two steps: 2^k may lie outside the range of a double where y 2^k does not.
  if (k > 1000) return y * power_of_two(k - 100) * 0x1p+100;
  if (k < -1000) return y * power_of_two(k + 100) * 0x1p-100;
  return y * power_of_two(k);
}

/// log x = k ln 2 + log(1 + f), 1 + f in [1/sqrt 2, sqrt 2]; log(1 + f) = 2 artanh s with s = f / (2 + f), written as
/// f - (f^2/2 - s (f^2/2 + R)), R = 2 s^2/3 + 2 s^4/5 + ..., so that the error of s meets a small factor only.
double log(double x) {
  constexpr double c[] = {2.0 / 3.0,  2.0 / 5.0,  2.0 / 7.0,  2.0 / 9.0,  2.0 / 11.0, 2.0 / 13.0,
                          2.0 / 15.0, 2.0 / 17.0, 2.0 / 19.0, 2.0 / 21.0, 2.0 / 23.0};
  constexpr Sum ln2 = {0x1.62e42fefa38p-1, 0x1.ef35793c7673p-45};
  if (is_nan(x) || x < 0.0) return nan;
  if (!(x > 0.0)) return -infinity;
  if (is_infinite(x)) return infinity;
  int k = 0;
  if (x < std::numeric_limits<double>::min()) {
    x *= 0x1p+54;
    k = -54;
  }
  constexpr std::uint64_t fraction_mask = 0x000FFFFFFFFFFFFFULL;
  const std::uint64_t bits = std::bit_cast<std::uint64_t>(x);
  k += static_cast<int>(bits >> 52U) - 1023;
  double m = std::bit_cast<double>((bits & fraction_mask) | 0x3FF0000000000000ULL);
  if (m > 0x1.6a09e667f3bcdp+0) {  // sqrt 2
    m *= 0.5;
    ++k;
  }
  const double f = m - 1.0;
  const double s = f / (2.0 + f);
  const double z = s * s;
  const double half = 0.5 * f * f;
  const double series = s * (half + z * polynomial(c, z));
  const double count = static_cast<double>(k);
  const double high = count * ln2.head;  // exact; 0 or at least 0.69, above |f|
  const double head = high + f;
  const double error = k == 0 ? 0.0 : (high - head) + f;
  return head + (error + ((series + count * ln2.tail) - half));
}

}  // namespace relnav::math
