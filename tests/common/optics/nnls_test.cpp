// SPDX-License-Identifier: Apache-2.0
// Non-negative least squares: small problems with known answers, and the conditions that only an optimum
// meets.
#include "common/optics/nnls.h"

#include <gtest/gtest.h>

#include <Eigen/QR>
#include <random>

namespace dermap {
namespace {

// The example of SciPy's documentation of scipy.optimize.nnls: x = (1.5, 1), and 0 for b = -1.
TEST(NonNegativeLeastSquares, SmallKnownProblem) {
  const Eigen::MatrixXd a{{1.0, 0.0}, {1.0, 0.0}, {0.0, 1.0}};
  const Eigen::VectorXd x = SolveNonNegative(a, Eigen::Vector3d(2.0, 1.0, 1.0));
  EXPECT_NEAR(x[0], 1.5, 1e-14);
  EXPECT_NEAR(x[1], 1.0, 1e-14);
  EXPECT_EQ(SolveNonNegative(a, Eigen::Vector3d(-1.0, -1.0, -1.0)), Eigen::Vector2d::Zero());
}

// By hand: without bounds 4 - 3t fits the points (0,4), (1,1), (2,-2) exactly; with slope >= 0 and offset >=
// 0 the slope is 0 and the offset the mean, 1. With the sign of t turned the first answer is within bounds.
TEST(NonNegativeLeastSquares, BindsWhatWouldBeNegative) {
  const Eigen::MatrixXd a{{1.0, 0.0}, {1.0, 1.0}, {1.0, 2.0}};
  const Eigen::VectorXd bound = SolveNonNegative(a, Eigen::Vector3d(4.0, 1.0, -2.0));
  EXPECT_NEAR(bound[0], 1.0, 1e-14);
  EXPECT_EQ(bound[1], 0.0);
  const Eigen::MatrixXd turned{{1.0, 0.0}, {1.0, -1.0}, {1.0, -2.0}};
  const Eigen::VectorXd free = SolveNonNegative(turned, Eigen::Vector3d(4.0, 1.0, -2.0));
  EXPECT_NEAR(free[0], 4.0, 1e-13);
  EXPECT_NEAR(free[1], 3.0, 1e-13);
}

void ExpectOptimal(const Eigen::MatrixXd& a, const Eigen::VectorXd& b, const Eigen::VectorXd& x) {
  const Eigen::VectorXd descent = a.transpose() * (b - a * x);
  const double scale = a.colwise().norm().maxCoeff() * b.norm();
  for (Eigen::Index j = 0; j < x.size(); ++j) {
    EXPECT_GE(x[j], 0.0);
    EXPECT_LT(descent[j], 1e-10 * scale) << j;
    EXPECT_TRUE(x[j] == 0.0 || descent[j] > -1e-10 * scale) << j;
  }
}

// Karush, Kuhn and Tucker: x >= 0, no descent where x > 0, none but into the bound where x = 0. For this
// convex problem that is the optimum and no other.
TEST(NonNegativeLeastSquares, MeetsTheConditionsOfTheOptimum) {
  std::mt19937 random(31);
  std::normal_distribution<double> normal;
  for (int trial = 0; trial < 50; ++trial) {
    const Eigen::MatrixXd a = Eigen::MatrixXd::NullaryExpr(20, 12, [&] { return normal(random); });
    const Eigen::VectorXd b = Eigen::VectorXd::NullaryExpr(20, [&] { return normal(random); });
    ExpectOptimal(a, b, SolveNonNegative(a, b));
  }
}

// Columns that nearly depend on each other, as neighbouring Gaussians do, and ones that wholly do.
TEST(NonNegativeLeastSquares, CopesWithDependentColumns) {
  Eigen::MatrixXd a(30, 18);
  for (int row = 0; row < 30; ++row) {
    for (int i = 0; i < 18; ++i) a(row, i) = std::exp(-std::pow(1.05, i) * row * 0.2);
  }
  const Eigen::VectorXd b = a.col(3) + 0.5 * a.col(9);
  const Eigen::VectorXd x = SolveNonNegative(a, b);
  ExpectOptimal(a, b, x);
  EXPECT_LT((a * x - b).norm(), 1e-8);
  a.col(5) = a.col(4);
  EXPECT_LT((a * SolveNonNegative(a, b) - b).norm(), 1e-8);
}

// A start changes the way, never the answer.
TEST(NonNegativeLeastSquares, AnyStartLeadsToTheSameAnswer) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  for (int trial = 0; trial < 20; ++trial) {
    const Eigen::MatrixXd a = Eigen::MatrixXd::NullaryExpr(15, 8, [&] { return normal(random); });
    const Eigen::VectorXd b = Eigen::VectorXd::NullaryExpr(15, [&] { return normal(random); });
    const Eigen::VectorXd start = Eigen::VectorXd::NullaryExpr(8, [&] { return normal(random); });
    EXPECT_LT((SolveNonNegative(a, b) - SolveNonNegative(a, b, start)).norm(), 1e-11);
  }
}

}  // namespace
}  // namespace dermap
