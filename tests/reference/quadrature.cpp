// SPDX-License-Identifier: Apache-2.0
// Gauss rules from the eigenvalues of the Jacobi matrix (Golub and Welsch 1969).
#include "tests/reference/quadrature.h"

#include <Eigen/Eigenvalues>
#include <cmath>

namespace dermap::reference {
namespace {

Eigen::MatrixXd LegendreJacobiMatrix(int n) {
  Eigen::MatrixXd jacobi = Eigen::MatrixXd::Zero(n, n);
  for (int k = 1; k < n; ++k) {
    jacobi(k, k - 1) = jacobi(k - 1, k) = k / std::sqrt(4.0 * k * k - 1.0);
  }
  return jacobi;
}

Rule RuleFromJacobi(const Eigen::MatrixXd& jacobi, double a, double b) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(jacobi);
  Rule rule;
  for (int i = 0; i < jacobi.rows(); ++i) {
    const double first = eigen.eigenvectors()(0, i);
    rule.nodes.push_back(0.5 * (a + b) + 0.5 * (b - a) * eigen.eigenvalues()(i));
    rule.weights.push_back((b - a) * first * first);  // the weight function's integral is 2 on [-1, 1]
  }
  return rule;
}

}  // namespace

Rule GaussLegendre(int n, double a, double b) {
  return RuleFromJacobi(LegendreJacobiMatrix(n), a, b);
}

Rule GaussRadauRight(int n, double a, double b) {
  Eigen::MatrixXd jacobi = LegendreJacobiMatrix(n);
  if (n > 1) {
    // The last diagonal element that makes 1 an eigenvalue (Golub 1973): 1 - beta^2 e with (J_{n-1} - 1) x =
    // e_last.
    const int m = n - 1;
    const Eigen::MatrixXd shifted = jacobi.topLeftCorner(m, m) - Eigen::MatrixXd::Identity(m, m);
    const double beta = jacobi(m, m - 1);
    const Eigen::VectorXd x = shifted.fullPivLu().solve(beta * beta * Eigen::VectorXd::Unit(m, m - 1));
    jacobi(m, m) = 1.0 + x(m - 1);
  } else {
    jacobi(0, 0) = 1.0;
  }
  Rule rule = RuleFromJacobi(jacobi, a, b);
  rule.nodes.back() = b;
  return rule;
}

}  // namespace dermap::reference
