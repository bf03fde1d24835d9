#pragma once
#include <cmath>

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
    const Vector d = b - a;
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

/// Sum of n' n over corresponding directions, and the rotation it speaks for.
///
/// The real part of L' M = M L, n' R = R n, is linear in the rotor; stacked over the lines, its least-squares solution is the
/// unit vector that belongs to the smallest eigenvalue of a 4 x 4 matrix. For unit directions that is Davenport's q-method
/// (largest eigenvalue of K), which is what is solved here.
template <typename S>
class RotorEquations {
 public:
  using Vector = Eigen::Matrix<S, 3, 1>;
  using Matrix = Eigen::Matrix<S, 3, 3>;

  void add(const Vector& n_T, const Vector& n_C) {
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) B_(r, c) += n_C(r) * n_T(c);
    }
    count_ += S(1);
  }
  /// R_CT with n_C = R_CT n_T. rank_deficient: all directions are parallel, or nearly so: two largest eigenvalues apart by
  /// less than least_gap times the number of directions.
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
      if (k != best && !(K(best, best) - K(k, k) > least_gap * count_)) return Status::rank_deficient;
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
  S count_ = S(0);
};

/// Dual part: m' = R m + t x n' over all lines, P t = Q with P = -[n' x], Q = m' - R m.
template <typename S>
class TranslatorEquations {
 public:
  using Vector = Eigen::Matrix<S, 3, 1>;

  TranslatorEquations() { equations_.clear(); }
  void add(const MotorLine<S>& line_C, const Vector& R_m) {
    const Vector& n = line_C.n;
    const S zero(0);
    equations_.add({zero, n(2), -n(1)}, line_C.m(0) - R_m(0));
    equations_.add({-n(2), zero, n(0)}, line_C.m(1) - R_m(1));
    equations_.add({n(1), -n(0), zero}, line_C.m(2) - R_m(2));
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
};

}  // namespace relnav
