// SPDX-License-Identifier: Apache-2.0
// Lawson and Hanson's active set method, by QR of the columns that are free (never by normal equations:
// neighbouring Gaussians are nearly dependent).
#include "common/optics/nnls.h"

#include <Eigen/QR>
#include <algorithm>
#include <cassert>
#include <vector>

namespace dermap {
namespace {

struct ActiveSet {
  explicit ActiveSet(Eigen::Index columns) : is_free(columns, false), barred(columns, false) {}

  std::vector<Eigen::Index> FreeColumns() const {
    std::vector<Eigen::Index> columns;
    for (std::size_t j = 0; j < is_free.size(); ++j) {
      if (is_free[j]) columns.push_back(static_cast<Eigen::Index>(j));
    }
    return columns;
  }
  std::vector<bool> is_free;
  std::vector<bool> barred;  // would turn negative at once: rounding has spoilt the sign of its gradient
};

// The bound column with the steepest descent, or -1 at the optimum.
Eigen::Index SteepestColumn(const ActiveSet& set, const Eigen::VectorXd& descent, double tolerance) {
  Eigen::Index best = -1;
  double steepest = tolerance;
  for (Eigen::Index j = 0; j < descent.size(); ++j) {
    if (!set.is_free[j] && !set.barred[j] && descent[j] > steepest) {
      steepest = descent[j];
      best = j;
    }
  }
  return best;
}

Eigen::VectorXd SolveFree(const Eigen::MatrixXd& a, const Eigen::VectorXd& b,
                          const std::vector<Eigen::Index>& columns) {
  const Eigen::MatrixXd free_part = a(Eigen::all, columns);
  return free_part.householderQr().solve(b);
}

// Goes from x towards the unconstrained solution of the free columns as far as the bounds allow, frees no
// more what arrives at its bound, and repeats until the solution is feasible.
void SolveWithinBounds(const Eigen::MatrixXd& a, const Eigen::VectorXd& b, ActiveSet& set,
                       Eigen::VectorXd& x) {
  for (;;) {
    const auto columns = set.FreeColumns();
    if (columns.empty()) return;
    const Eigen::VectorXd target = SolveFree(a, b, columns);
    double share = 1.0;
    for (std::size_t i = 0; i < columns.size(); ++i) {
      const double from = x[columns[i]];
      if (target[i] <= 0.0) share = std::min(share, from / (from - target[i]));
    }
    for (std::size_t i = 0; i < columns.size(); ++i) {
      double& value = x[columns[i]];
      const double from = value;
      value += share * (target[i] - from);
      const bool blocks = target[i] <= 0.0 && from / (from - target[i]) <= share;
      if (blocks || value <= 0.0) {
        value = 0.0;
        set.is_free[columns[i]] = false;
      }
    }
    if (share >= 1.0) return;
  }
}

}  // namespace

Eigen::VectorXd SolveNonNegative(const Eigen::MatrixXd& a, const Eigen::VectorXd& b,
                                 const Eigen::VectorXd& start) {
  assert(a.rows() == b.size() && a.rows() >= a.cols());
  Eigen::VectorXd x = Eigen::VectorXd::Zero(a.cols());
  ActiveSet set(a.cols());
  if (start.size() == a.cols() && start.maxCoeff() > 0.0) {
    x = start.cwiseMax(0.0);
    for (Eigen::Index j = 0; j < x.size(); ++j) set.is_free[j] = x[j] > 0.0;
    SolveWithinBounds(a, b, set, x);
  }
  const double tolerance = 1e-12 * a.colwise().norm().maxCoeff() * b.norm();
  const Eigen::Index step_limit =
      10 * a.cols();  // in exact arithmetic the residual falls with each step: no cycles
  for (Eigen::Index step = 0; step < step_limit; ++step) {
    const Eigen::VectorXd descent = a.transpose() * (b - a * x);
    const Eigen::Index entering = SteepestColumn(set, descent, tolerance);
    if (entering < 0) break;
    const Eigen::VectorXd before = x;
    set.is_free[entering] = true;
    SolveWithinBounds(a, b, set, x);
    if (!set.is_free[entering] && x == before) {
      set.barred[entering] = true;
    } else {
      set.barred.assign(set.barred.size(), false);
    }
  }
  return x;
}

}  // namespace dermap
