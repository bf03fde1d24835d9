#pragma once
#include <cmath>

#include <Eigen/Core>

namespace relnav {

/// Eigenvalues and vectors of a small symmetric matrix by cyclic Jacobi rotations (Golub, Van Loan, "Matrix Computations",
/// 8.5), for any scalar with sqrt. `A` ends with the eigenvalues on its diagonal, V with unit vectors in its columns, in no
/// order. Bounded: at most 12 sweeps; 4 to 6 are enough for double.
template <typename S, int N>
void symmetric_eigen(Eigen::Matrix<S, N, N>& A, Eigen::Matrix<S, N, N>& V) {
  using std::sqrt;
  constexpr int most_sweeps = 12;
  V.setIdentity();
  for (int sweep = 0; sweep < most_sweeps; ++sweep) {
    bool rotated = false;
    for (int p = 0; p < N - 1; ++p) {
      for (int q = p + 1; q < N; ++q) {
        const S off = A(p, q);
        const S gap = A(q, q) - A(p, p);
        // Nothing left to gain: the element vanishes beside the gap or the diagonal.
        const S size = (off < S(0) ? -off : off);
        const S app = A(p, p) < S(0) ? -A(p, p) : A(p, p);
        const S aqq = A(q, q) < S(0) ? -A(q, q) : A(q, q);
        if (!(app + aqq + size > app + aqq)) continue;
        rotated = true;
        // tan of the smaller angle that makes the element zero: t = sign(gap) 2 off / (|gap| + sqrt(gap^2 + 4 off^2)).
        const S two_off = off + off;
        // The squares relative to the larger one: they would leave the range of small elements, first in fixed point.
        const S width = gap < S(0) ? -gap : gap;
        const S height = size + size;
        const S larger = width < height ? height : width;
        const S ratio = (width < height ? width : height) / larger;
        const S root = larger * sqrt(S(1) + ratio * ratio);
        const S t = gap < S(0) ? -two_off / (root - gap) : two_off / (root + gap);
        const S c = S(1) / sqrt(S(1) + t * t);
        const S s = t * c;
        for (int k = 0; k < N; ++k) {
          const S akp = A(k, p), akq = A(k, q);
          A(k, p) = c * akp - s * akq;
          A(k, q) = s * akp + c * akq;
        }
        for (int k = 0; k < N; ++k) {
          const S apk = A(p, k), aqk = A(q, k);
          A(p, k) = c * apk - s * aqk;
          A(q, k) = s * apk + c * aqk;
          const S vkp = V(k, p), vkq = V(k, q);
          V(k, p) = c * vkp - s * vkq;
          V(k, q) = s * vkp + c * vkq;
        }
      }
    }
    if (!rotated) return;
  }
}

}  // namespace relnav
