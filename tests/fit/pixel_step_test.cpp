// SPDX-License-Identifier: Apache-2.0
// The bounded step of one pixel.
#include "fit/pixel_step.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <utility>
#include <vector>

namespace dermap {
namespace {

constexpr FreeVector kFar{100, 100, 100, 100, 100};
constexpr FreeVector kMinusFar{-100, -100, -100, -100, -100};

PixelSystem TwoByTwo() {
  PixelSystem system;
  system.count = 2;
  system.Add({2, 0}, 2);  // 2 x = 2
  system.Add({1, 3}, 7);  // x + 3 y = 7
  return system;
}

// x = 1, y = 2 by hand.
TEST(PixelStep, SolvesASquareSystem) {
  const FreeVector step = BoundedStep(TwoByTwo(), 0.0, {}, kMinusFar, kFar);
  EXPECT_NEAR(step[0], 1.0, 1e-12);
  EXPECT_NEAR(step[1], 2.0, 1e-12);
}

// With y held at 0.5, x minimises (2 x - 2)^2 + (x + 1.5 - 7)^2: 5 x = 9.5.
TEST(PixelStep, SolvesAgainForTheOthersWhereOneMeetsItsBound) {
  FreeVector upper = kFar;
  upper[1] = 0.5;
  const FreeVector step = BoundedStep(TwoByTwo(), 0.0, {}, kMinusFar, upper);
  EXPECT_NEAR(step[1], 0.5, 1e-12);
  EXPECT_NEAR(step[0], 1.9, 1e-12);
}

// Levenberg's limits: no damping is Gauss-Newton, endless damping is the gradient's direction.
TEST(PixelStep, DampingTurnsTheStepToTheGradient) {
  const PixelSystem system = TwoByTwo();
  const FreeVector step = BoundedStep(system, 1e9, {}, kMinusFar, kFar);
  EXPECT_NEAR(step[0] * 1e9 / system.rhs[0], 1.0, 1e-6);
  EXPECT_NEAR(step[1] * 1e9 / system.rhs[1], 1.0, 1e-6);
}

// The inverse of a diagonal matrix, and the textbook 2 x 2 inverse: normal matrix [[5, 3], [3, 9]],
// determinant 36.
TEST(PixelStep, InverseDiagonalIsTheVariance) {
  const FreeVector variance = InverseDiagonal(TwoByTwo(), 0.0);
  EXPECT_NEAR(variance[0], 9.0 / 36.0, 1e-12);
  EXPECT_NEAR(variance[1], 5.0 / 36.0, 1e-12);
}

// A prior is one more equation: without data the step leads to its centre.
TEST(PixelStep, PriorAloneLeadsToItsCentre) {
  PixelSystem system;
  system.count = 1;
  system.AddPrior(0, 4.0, 0.7, 0.2);
  EXPECT_NEAR(BoundedStep(system, 0.0, {0.2}, kMinusFar, kFar)[0], 0.5, 1e-12);
}

// The definition of the bounds, on 2000 random systems: never left, and never worse than not moving.
TEST(PixelStep, RandomSystemsStayWithinBoundsAndGain) {
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  for (int trial = 0; trial < 2000; ++trial) {
    PixelSystem system;
    system.count = 5;
    std::vector<std::pair<FreeVector, double>> equations;
    for (int e = 0; e < 8; ++e) {
      FreeVector row;
      for (double& value : row) value = normal(random);
      equations.emplace_back(row, 3 * normal(random));
      system.Add(row, equations.back().second);
    }
    FreeVector position, lower, upper;
    for (int j = 0; j < 5; ++j) {
      lower[j] = -std::abs(normal(random));
      upper[j] = std::abs(normal(random));
      position[j] = lower[j] + 0.5 * (upper[j] - lower[j]);
    }
    const FreeVector step = BoundedStep(system, 0.1, position, lower, upper);
    double before = 0.0, after = 0.0;
    for (const auto& [row, residual] : equations) {
      double moved = residual;
      for (int j = 0; j < 5; ++j) moved -= row[j] * step[j];
      before += residual * residual;
      after += moved * moved;
    }
    for (int j = 0; j < 5; ++j) {
      ASSERT_GE(position[j] + step[j], lower[j] - 1e-12);
      ASSERT_LE(position[j] + step[j], upper[j] + 1e-12);
    }
    ASSERT_LT(after, before);
  }
}

}  // namespace
}  // namespace dermap
