#include "tests/support/dense.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

// Loops over single elements: what Eigen makes of the same takes the compiler 18 s, on each target.
namespace relnav::test {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

MatrixXd unit_matrix(Index n) {
  MatrixXd I(n, n);
  for (Index r = 0; r < n; ++r) {
    for (Index c = 0; c < n; ++c) I(r, c) = r == c ? 1.0 : 0.0;
  }
  return I;
}

double column_product(const MatrixXd& A, Index a, const MatrixXd& B, Index b, Index from) {
  double sum = 0.0;
  for (Index r = from; r < A.rows(); ++r) sum += A(r, a) * B(r, b);
  return sum;
}

/// B -= 2 v v' B / v'v for the column k of V, from its row k on.
void reflect(const MatrixXd& V, Index k, MatrixXd& B) {
  const double v_squared = column_product(V, k, V, k, k);
  if (!(v_squared > 0.0)) return;
  for (Index c = 0; c < B.cols(); ++c) {
    const double factor = 2.0 * column_product(V, k, B, c, k) / v_squared;
    for (Index r = k; r < B.rows(); ++r) B(r, c) -= factor * V(r, k);
  }
}

/// Householder: A becomes R (above its diagonal), what is returned holds the vectors of the reflections.
MatrixXd triangulate(MatrixXd& A) {
  MatrixXd V(A.rows(), A.cols());
  for (Index k = 0; k < A.cols(); ++k) {
    for (Index r = 0; r < A.rows(); ++r) V(r, k) = r < k || k + 1 == A.rows() ? 0.0 : A(r, k);
    const double norm = std::sqrt(column_product(V, k, V, k, k));
    if (k + 1 < A.rows()) V(k, k) += A(k, k) >= 0.0 ? norm : -norm;
    reflect(V, k, A);
  }
  return V;
}

/// Turns the columns p and q of A.
void turn_columns(MatrixXd& A, Index p, Index q, double c, double s) {
  for (Index r = 0; r < A.rows(); ++r) {
    const double a = A(r, p);
    A(r, p) = c * a - s * A(r, q);
    A(r, q) = s * a + c * A(r, q);
  }
}

}  // namespace

MatrixXd product(const MatrixXd& A, const MatrixXd& B) {
  MatrixXd C(A.rows(), B.cols());
  for (Index c = 0; c < B.cols(); ++c) {
    for (Index r = 0; r < A.rows(); ++r) C(r, c) = 0.0;
    for (Index k = 0; k < A.cols(); ++k) {
      const double* a = A.data() + k * A.rows();
      const double b = B(k, c);
      for (Index r = 0; r < A.rows(); ++r) C(r, c) += a[r] * b;
    }
  }
  return C;
}

MatrixXd congruence(const MatrixXd& A, const MatrixXd& P) { return product(product(A, P), A.transpose()); }

double mahalanobis_squared(const VectorXd& d, const MatrixXd& P) {
  const MatrixXd x = solve_symmetric(P, d);
  double sum = 0.0;
  for (Index i = 0; i < d.size(); ++i) sum += d(i) * x(i, 0);
  return sum;
}

VectorXd eigenvalues_of(const MatrixXd& symmetric) {
  // Jacobi's rotations, in sweeps. Elements of about 1: a product of two stays in the range of numbers.
  MatrixXd A = symmetric;
  const Index n = A.rows();
  double largest = 0.0;
  for (Index i = 0; i < A.size(); ++i) largest = std::max(largest, std::fabs(A.data()[i]));
  const int exponent = largest > 0.0 && std::isfinite(largest) ? std::ilogb(largest) : 0;
  for (Index i = 0; i < A.size(); ++i) A.data()[i] = std::scalbn(A.data()[i], -exponent);
  bool turned = true;
  for (int sweep = 0; turned && sweep < 60; ++sweep) {
    turned = false;
    for (Index p = 0; p + 1 < n; ++p) {
      for (Index q = p + 1; q < n; ++q) {
        if (std::fabs(A(p, q)) <= 1e-17 * std::sqrt(std::fabs(A(p, p) * A(q, q))) || A(p, q) == 0.0) continue;
        turned = true;
        const double tau = (A(q, q) - A(p, p)) / (2.0 * A(p, q));
        const double t = (tau >= 0.0 ? 1.0 : -1.0) / (std::fabs(tau) + std::hypot(1.0, tau));
        const double c = 1.0 / std::hypot(1.0, t);
        const double s = t * c;
        turn_columns(A, p, q, c, s);
        for (Index k = 0; k < n; ++k) {
          const double a = A(p, k);
          A(p, k) = c * a - s * A(q, k);
          A(q, k) = s * a + c * A(q, k);
        }
        A(p, q) = A(q, p) = 0.0;
      }
    }
  }
  VectorXd values(n);
  for (Index i = 0; i < n; ++i) values(i) = std::scalbn(A(i, i), exponent);
  std::sort(values.data(), values.data() + n);
  return values;
}

MatrixXd orthogonal_of(const MatrixXd& A) {
  MatrixXd R = A;
  const MatrixXd V = triangulate(R);
  MatrixXd Q = unit_matrix(A.rows());
  for (Index k = A.cols() - 1; k >= 0; --k) reflect(V, k, Q);
  return Q;
}

MatrixXd solve_symmetric(const MatrixXd& A, const MatrixXd& b) {
  // Gauss, the largest pivot of the column.
  MatrixXd U = A;
  MatrixXd x = b;
  const Index n = U.rows();
  for (Index k = 0; k < n; ++k) {
    Index pivot = k;
    for (Index r = k + 1; r < n; ++r) {
      if (std::fabs(U(r, k)) > std::fabs(U(pivot, k))) pivot = r;
    }
    for (Index c = 0; c < n; ++c) std::swap(U(k, c), U(pivot, c));
    for (Index c = 0; c < x.cols(); ++c) std::swap(x(k, c), x(pivot, c));
    for (Index r = k + 1; r < n; ++r) {
      const double factor = U(r, k) / U(k, k);
      for (Index c = k; c < n; ++c) U(r, c) -= factor * U(k, c);
      for (Index c = 0; c < x.cols(); ++c) x(r, c) -= factor * x(k, c);
    }
  }
  for (Index c = 0; c < x.cols(); ++c) {
    for (Index r = n - 1; r >= 0; --r) {
      for (Index k = r + 1; k < n; ++k) x(r, c) -= U(r, k) * x(k, c);
      x(r, c) /= U(r, r);
    }
  }
  return x;
}

VectorXd solve_least_squares(const MatrixXd& A, const VectorXd& b) {
  MatrixXd R = A;
  MatrixXd right = b;
  const MatrixXd V = triangulate(R);
  for (Index k = 0; k < A.cols(); ++k) reflect(V, k, right);
  VectorXd x(A.cols());
  for (Index r = A.cols() - 1; r >= 0; --r) {
    x(r) = right(r, 0);
    for (Index k = r + 1; k < A.cols(); ++k) x(r) -= R(r, k) * x(k);
    x(r) /= R(r, r);
  }
  return x;
}

SingularVectors singular_vectors_of(const MatrixXd& A) {
  // Hestenes: turns the columns until each stands at right angles to all others.
  MatrixXd B = A;
  const Index n = B.cols();
  MatrixXd V = unit_matrix(n);
  bool turned = true;
  for (int sweep = 0; turned && sweep < 60; ++sweep) {
    turned = false;
    for (Index p = 0; p + 1 < n; ++p) {
      for (Index q = p + 1; q < n; ++q) {
        const double pp = column_product(B, p, B, p, 0);
        const double qq = column_product(B, q, B, q, 0);
        const double pq = column_product(B, p, B, q, 0);
        if (std::fabs(pq) <= 1e-16 * std::sqrt(pp * qq)) continue;
        turned = true;
        const double tau = (qq - pp) / (2.0 * pq);
        const double t = (tau >= 0.0 ? 1.0 : -1.0) / (std::fabs(tau) + std::hypot(1.0, tau));
        const double c = 1.0 / std::hypot(1.0, t);
        turn_columns(B, p, q, c, t * c);
        turn_columns(V, p, q, c, t * c);
      }
    }
  }
  std::vector<double> values;
  std::vector<Index> order(static_cast<std::size_t>(n));
  std::iota(order.begin(), order.end(), 0);
  for (Index k = 0; k < n; ++k) values.push_back(std::sqrt(column_product(B, k, B, k, 0)));
  const auto value = [&](Index k) { return values[static_cast<std::size_t>(k)]; };
  std::stable_sort(order.begin(), order.end(), [&](Index a, Index b) { return value(a) > value(b); });
  SingularVectors out{MatrixXd(B.rows(), n), MatrixXd(n, n)};
  for (Index k = 0; k < n; ++k) {
    const Index from = order[static_cast<std::size_t>(k)];
    for (Index r = 0; r < B.rows(); ++r) out.U(r, k) = value(from) > 0.0 ? B(r, from) / value(from) : 0.0;
    for (Index r = 0; r < n; ++r) out.V(r, k) = V(r, from);
  }
  return out;
}

}  // namespace relnav::test
