// SPDX-License-Identifier: Apache-2.0
// Non-negative least squares, which Eigen 3.4 lacks.
#pragma once

#include <Eigen/Core>

namespace dermap {

// x >= 0 that minimises |A x - b|: the active set method NNLS of [Lawson and Hanson 1974, "Solving Least
// Squares Problems", chapter 23]. A needs at least as many rows as columns. `start`: the solution of a
// similar problem, which saves steps and changes nothing else; or empty.
Eigen::VectorXd SolveNonNegative(const Eigen::MatrixXd& a, const Eigen::VectorXd& b,
                                 const Eigen::VectorXd& start = {});

}  // namespace dermap
