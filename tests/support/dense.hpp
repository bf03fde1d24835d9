#pragma once
// Eigen's decompositions for the tests, compiled once: each costs every file that names it several seconds.
#include "fsw/math/types.hpp"

namespace relnav::test {

/// d' P^-1 d.
double mahalanobis_squared(const Eigen::VectorXd& d, const Eigen::MatrixXd& P);

/// Of a symmetric matrix, in rising order.
Eigen::VectorXd eigenvalues_of(const Eigen::MatrixXd& symmetric);

/// The orthogonal factor of a square matrix.
Eigen::MatrixXd orthogonal_of(const Eigen::MatrixXd& A);

/// x of A x = b for symmetric A.
Eigen::MatrixXd solve_symmetric(const Eigen::MatrixXd& A, const Eigen::MatrixXd& b);

/// x that makes |A x - b| least.
Eigen::VectorXd solve_least_squares(const Eigen::MatrixXd& A, const Eigen::VectorXd& b);

}  // namespace relnav::test
