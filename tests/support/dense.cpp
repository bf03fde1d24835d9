#include "tests/support/dense.hpp"

#include <Eigen/Dense>

namespace relnav::test {

double mahalanobis_squared(const Eigen::VectorXd& d, const Eigen::MatrixXd& P) { return d.dot(P.ldlt().solve(d)); }

Eigen::VectorXd eigenvalues_of(const Eigen::MatrixXd& symmetric) {
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(symmetric, Eigen::EigenvaluesOnly).eigenvalues();
}

Eigen::MatrixXd orthogonal_of(const Eigen::MatrixXd& A) { return A.householderQr().householderQ(); }

Eigen::MatrixXd solve_symmetric(const Eigen::MatrixXd& A, const Eigen::MatrixXd& b) { return A.ldlt().solve(b); }

Eigen::VectorXd solve_least_squares(const Eigen::MatrixXd& A, const Eigen::VectorXd& b) {
  return A.householderQr().solve(b);
}

}  // namespace relnav::test
