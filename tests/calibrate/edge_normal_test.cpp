// SPDX-License-Identifier: Apache-2.0
// Eliminating stretches one by one against the whole matrix.
#include "calibrate/edge_normal.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <random>

namespace dermap {
namespace {

constexpr int kShared = EdgeNormal::kShared, kOwn = EdgeNormal::kOwn, kStretches = 5;
constexpr int kUnknowns = kShared + kOwn * kStretches;

// Random samples, each of one stretch, in both forms.
struct Pair {
  EdgeNormal normal;
  Eigen::MatrixXd whole = Eigen::MatrixXd::Zero(kUnknowns, kUnknowns);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(kUnknowns);
};

Pair RandomNormal() {
  Pair pair;
  pair.normal.stretches.resize(kStretches);
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  for (int k = 0; k < 400; ++k) {
    const int g = k % kStretches;
    Eigen::VectorXd row = Eigen::VectorXd::Zero(kUnknowns);
    for (int i = 0; i < kShared; ++i) row(i) = normal(random);
    for (int i = 0; i < kOwn; ++i) row(kShared + kOwn * g + i) = normal(random);
    const double value = normal(random);
    pair.whole += row * row.transpose();
    pair.right += value * row;
    auto& stretch = pair.normal.stretches[static_cast<std::size_t>(g)];
    for (int i = 0; i < kShared; ++i) {
      pair.normal.right[i] += value * row(i);
      for (int j = 0; j <= i; ++j) pair.normal.shared[i][j] += row(i) * row(j);
    }
    for (int i = 0; i < kOwn; ++i) {
      const double own = row(kShared + kOwn * g + i);
      stretch.right[i] += value * own;
      for (int j = 0; j <= i; ++j) stretch.own[i][j] += own * row(kShared + kOwn * g + j);
      for (int j = 0; j < kShared; ++j) stretch.cross[i][j] += own * row(j);
    }
  }
  return pair;
}

// Expected: Eigen's dense solver.
TEST(EdgeNormal, SolvesAsTheWholeMatrixDoes) {
  const Pair pair = RandomNormal();
  const Eigen::VectorXd expected = pair.whole.ldlt().solve(pair.right);
  const EdgeStep step = Solve(pair.normal);
  ASSERT_EQ(step.own.size(), std::size_t{kStretches});
  for (int i = 0; i < kShared; ++i) EXPECT_NEAR(step.shared[i], expected(i), 1e-7);
  for (int g = 0; g < kStretches; ++g) {
    for (int i = 0; i < kOwn; ++i)
      EXPECT_NEAR(step.own[static_cast<std::size_t>(g)][i], expected(kShared + kOwn * g + i), 1e-7);
  }
}

// Expected: Eigen's dense inverse.
TEST(EdgeNormal, VarianceCountsWhatStretchesLeaveOpen) {
  const Pair pair = RandomNormal();
  EdgeNormal::Shared direction{};
  direction[3] = direction[4] = 0.5;
  Eigen::VectorXd along = Eigen::VectorXd::Zero(kUnknowns);
  along(3) = along(4) = 0.5;
  const double expected = along.dot(pair.whole.ldlt().solve(along));
  EXPECT_NEAR(VarianceAlong(pair.normal, direction), expected, 1e-7 * expected + 1e-9);
}

}  // namespace
}  // namespace dermap
