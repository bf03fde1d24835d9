#pragma once
// Decompositions for the tests in plain loops: Eigen's cost every file that names one several seconds.
#include "fsw/math/types.hpp"

namespace relnav::test {

Eigen::MatrixXd product(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B);

/// A P A'.
Eigen::MatrixXd congruence(const Eigen::MatrixXd& A, const Eigen::MatrixXd& P);

/// d' P^-1 d.
double mahalanobis_squared(const Eigen::VectorXd& d, const Eigen::MatrixXd& P);

/// Of a symmetric matrix, in rising order.
Eigen::VectorXd eigenvalues_of(const Eigen::MatrixXd& symmetric);

/// The orthogonal factor of a square matrix.
Eigen::MatrixXd orthogonal_of(const Eigen::MatrixXd& A);

/// x of A x = b for symmetric A.
Eigen::MatrixXd solve_symmetric(const Eigen::MatrixXd& A, const Eigen::MatrixXd& b);

/// x that makes |A x - b| least. A has full rank.
Eigen::VectorXd solve_least_squares(const Eigen::MatrixXd& A, const Eigen::VectorXd& b);

struct SingularVectors {
  Eigen::MatrixXd U;  ///< as many columns as A; zero where the singular value is
  Eigen::MatrixXd V;
};

/// A = U S V', singular values falling. A has no more columns than rows.
SingularVectors singular_vectors_of(const Eigen::MatrixXd& A);

}  // namespace relnav::test
