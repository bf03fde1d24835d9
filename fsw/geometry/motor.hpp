#pragma once
#include <algorithm>
#include <cmath>
#include <cstddef>

#include <Eigen/Core>

#include "fsw/base/status.hpp"
#include "fsw/math/normal_equations.hpp"
#include "fsw/math/symmetric_eigen.hpp"

namespace relnav {

/// A line of motor algebra, L = n + I m: unit direction n and moment m about the origin, as vectors. Bayro-Corrochano,
/// Daniilidis, Sommer 2000. The moment is the same for any point of the line: m = a x n.
template <typename S>
struct MotorLine {
  using Vector = Eigen::Matrix<S, 3, 1>;
  Vector n = Vector::Zero();
  Vector m = Vector::Zero();

  /// Through a and b, which must differ. Unit directions rather than b - a: they make the position better.
  [[nodiscard]] static MotorLine through(const Vector& a, const Vector& b) {
    using std::sqrt;
    Vector d = b - a;
    // Over the largest component first: squares of long and of short ones would leave the range of a fixed-point number.
    S largest(0);
    for (int k = 0; k < 3; ++k) largest = std::max(largest, d(k) < S(0) ? -d(k) : d(k));
    for (int k = 0; k < 3; ++k) d(k) /= largest;
    const S scale = S(1) / sqrt(d(0) * d(0) + d(1) * d(1) + d(2) * d(2));
    MotorLine line;
    for (int k = 0; k < 3; ++k) line.n(k) = scale * d(k);
    line.m = cross(a, line.n);
    return line;
  }
  [[nodiscard]] static Vector cross(const Vector& a, const Vector& b) {
    return Vector(a(1) * b(2) - a(2) * b(1), a(2) * b(0) - a(0) * b(2), a(0) * b(1) - a(1) * b(0));
  }
};

/// Mean of n' n over corresponding directions, and the rotation it speaks for.
///
/// The real part of L' M = M L, n' R = R n, is linear in the rotor; stacked over the lines, its least-squares solution is the
/// unit vector that belongs to the smallest eigenvalue of a 4 x 4 matrix. For unit directions that is Davenport's q-method
/// (largest eigenvalue of K), which is what is solved here.
template <typename S>
class RotorEquations {
 public:
  using Vector = Eigen::Matrix<S, 3, 1>;
  using Matrix = Eigen::Matrix<S, 3, 3>;

  /// So many directions will be added.
  explicit RotorEquations(std::size_t count) : weight_(S(1) / S(static_cast<int>(count))) {}
  void add(const Vector& n_T, const Vector& n_C) {
    for (int r = 0; r < 3; ++r) {
      const S weighted = weight_ * n_C(r);
      for (int c = 0; c < 3; ++c) B_(r, c) += weighted * n_T(c);
    }
  }
  /// R_CT with n_C = R_CT n_T. rank_deficient: all directions are parallel, or nearly so: two largest eigenvalues apart by
  /// less than least_gap.
  Status solve(const S& least_gap, Matrix& R_CT) const {
    // K for the quaternion (x y z w) of the active rotation: maximises the trace of R' B.
    Eigen::Matrix<S, 4, 4> K, V;
    const S trace = B_(0, 0) + B_(1, 1) + B_(2, 2);
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) K(r, c) = B_(r, c) + B_(c, r) - (r == c ? trace : S(0));
    }
    K(3, 3) = trace;
    K(0, 3) = K(3, 0) = B_(2, 1) - B_(1, 2);
    K(1, 3) = K(3, 1) = B_(0, 2) - B_(2, 0);
    K(2, 3) = K(3, 2) = B_(1, 0) - B_(0, 1);
    symmetric_eigen<S, 4>(K, V);
    int best = 0;
    for (int k = 1; k < 4; ++k) best = K(k, k) > K(best, best) ? k : best;
    for (int k = 0; k < 4; ++k) {
      if (k != best && !(K(best, best) - K(k, k) > least_gap)) return Status::rank_deficient;
    }
    const S x = V(0, best), y = V(1, best), z = V(2, best), w = V(3, best);
    const S s = S(2) / (x * x + y * y + z * z + w * w);
    R_CT << S(1) - s * (y * y + z * z), s * (x * y - z * w), s * (x * z + y * w),  //
        s * (x * y + z * w), S(1) - s * (x * x + z * z), s * (y * z - x * w),      //
        s * (x * z - y * w), s * (y * z + x * w), S(1) - s * (x * x + y * y);
    return Status::ok;
  }

 private:
  Matrix B_ = Matrix::Zero();
  S weight_;
};

/// Dual part: m' = R m + t x n' over all lines, P t = Q with P = -[n' x], Q = m' - R m, with rows that make the elements of
/// the normal equations 256 at most: far away all lines are nearly parallel to the line of sight by the noise of their depth,
/// and pivots small.
template <typename S>
class TranslatorEquations {
 public:
  using Vector = Eigen::Matrix<S, 3, 1>;

  /// So many lines will be added.
  explicit TranslatorEquations(std::size_t count) {
    using std::sqrt;
    equations_.clear();
    weight_ = S(16) / sqrt(S(static_cast<int>(count)));
  }
  void add(const MotorLine<S>& line_C, const Vector& R_m) {
    Vector n;
    Vector q;
    for (int k = 0; k < 3; ++k) {
      n(k) = weight_ * line_C.n(k);
      q(k) = weight_ * (line_C.m(k) - R_m(k));
    }
    const S zero(0);
    equations_.add({zero, n(2), -n(1)}, q(0));
    equations_.add({-n(2), zero, n(0)}, q(1));
    equations_.add({n(1), -n(0), zero}, q(2));
  }
  /// rank_deficient: all lines are parallel.
  Status solve(const S& least_pivot, Vector& t_CT) {
    const Status status = equations_.factorise(least_pivot);
    if (status != Status::ok) return status;
    S gain;
    t_CT = equations_.solution(gain);
    return Status::ok;
  }

 private:
  NormalEquations<S, 3> equations_;
  S weight_;
};

}  // namespace relnav
