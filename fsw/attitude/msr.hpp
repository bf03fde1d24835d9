#pragma once
#include "fsw/math/types.hpp"

namespace relnav {

/// Rodrigues parameters in one of four sets (Shuster's method of sequential rotations), for any scalar: double, float,
/// Fixed. R_CT = C(g) R^(i); conventions and source as in RodriguesChart, which is for filters; this is for iterations.
/// While each correction is followed by switch_if_due(), every |g_k| <= 1 at rest. With corrections of |dg_k| <= 1/2 and
/// dg'g <= 1/2 no |g_k| exceeds 5 in between, and with 1/4 no number here 7/3, which Q2.29 holds.
template <typename S>
struct GibbsSet {
  using Vector = Eigen::Matrix<S, 3, 1>;
  using Matrix = Eigen::Matrix<S, 3, 3>;

  Vector g = Vector::Zero();
  int set = 0;

  /// C(g) R^(i), (1)-(4).
  [[nodiscard]] Matrix dcm() const {
    const S x = g(0), y = g(1), z = g(2);
    const S xx = x * x, yy = y * y, zz = z * z;
    const S half(0.5);
    const S two = S(1) / (half + half * (xx + yy + zz));  // 2 / (1 + g'g), from 1/2 to 2
    const S scale = half * two;
    const S xy = x * y, xz = x * z, yz = y * z;
    Matrix R;
    R(0, 0) = scale * (S(1) + xx - yy - zz);
    R(1, 1) = scale * (S(1) - xx + yy - zz);
    R(2, 2) = scale * (S(1) - xx - yy + zz);
    R(0, 1) = two * (xy + z);
    R(1, 0) = two * (xy - z);
    R(0, 2) = two * (xz - y);
    R(2, 0) = two * (xz + y);
    R(1, 2) = two * (yz + x);
    R(2, 1) = two * (yz - x);
    if (set != 0) {
      for (int k = 0; k < 3; ++k) {
        if (k == set - 1) continue;
        for (int r = 0; r < 3; ++r) R(r, k) = -R(r, k);
      }
    }
    return R;
  }

  /// g <- dg * g, (10): C(dg) is applied from the left. dg'g must stay away from 1.
  void correct(const Vector& dg) {
    const S scale = S(1) / (S(1) - (dg(0) * g(0) + dg(1) * g(1) + dg(2) * g(2)));
    const Vector sum(dg(0) + g(0) - (dg(1) * g(2) - dg(2) * g(1)), dg(1) + g(1) - (dg(2) * g(0) - dg(0) * g(2)),
                     dg(2) + g(2) - (dg(0) * g(1) - dg(1) * g(0)));
    for (int k = 0; k < 3; ++k) g(k) = scale * sum(k);
  }

  /// (5) with the rule: j names the largest |g_j|, due when it exceeds 1. True when it switched.
  [[nodiscard]] bool switch_if_due() {
    int j = 0;
    S largest = magnitude(g(0));
    for (int k = 1; k < 3; ++k) {
      if (magnitude(g(k)) > largest) {
        j = k;
        largest = magnitude(g(k));
      }
    }
    if (!(largest > S(1))) return false;
    const int k = j == 2 ? 0 : j + 1;
    const int l = k == 2 ? 0 : k + 1;
    const S pivot = g(j);
    Vector next;
    next(j) = S(-1) / pivot;
    next(k) = g(l) / pivot;
    next(l) = -g(k) / pivot;
    g = next;
    set = set == 0 ? j + 1 : (set == j + 1 ? 0 : 6 - (j + 1) - set);
    return true;
  }

 private:
  [[nodiscard]] static S magnitude(const S& value) { return value < S(0) ? -value : value; }
};

}  // namespace relnav
