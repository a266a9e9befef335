// SPDX-License-Identifier: Apache-2.0
// Interpolation against the function that was sampled.
#include "fit/spectra/grid3.h"

#include <gtest/gtest.h>

#include <cmath>

namespace dermap {
namespace {

double Smooth(double x, double y, double z) {
  return std::exp(-x) * std::sin(y) + z * z * x;
}

Grid3 Sampled(int stencil) {
  const std::array<GridAxis, 3> axes{GridAxis{0.0, 2.0, 9}, GridAxis{-1.0, 2.0, 11}, GridAxis{1.0, 3.0, 8}};
  std::vector<double> values;
  for (int i = 0; i < axes[0].count; ++i) {
    for (int j = 0; j < axes[1].count; ++j) {
      for (int k = 0; k < axes[2].count; ++k)
        values.push_back(Smooth(axes[0].At(i), axes[1].At(j), axes[2].At(k)));
    }
  }
  return Grid3(axes, values, stencil);
}

// Source: the function itself; Lagrange's remainder with steps of 0.3 is below 1e-5 for six points.
TEST(Grid3, FollowsASmoothFunctionAndItsSlopes) {
  const Grid3 grid = Sampled(6);
  for (const double x : {0.01, 0.7, 1.99}) {
    for (const double y : {-0.95, 0.4, 1.7}) {
      for (const double z : {1.05, 2.2, 2.9}) {
        const Grid3::Sample at = grid.At({x, y, z});
        EXPECT_NEAR(at.value, Smooth(x, y, z), 1e-5);
        EXPECT_NEAR(at.slope[0], -std::exp(-x) * std::sin(y) + z * z, 3e-4);
        EXPECT_NEAR(at.slope[1], std::exp(-x) * std::cos(y), 3e-4);
        EXPECT_NEAR(at.slope[2], 2.0 * z * x, 3e-4);
      }
    }
  }
}

// Source: two points are a straight line, exact for what is linear along an axis (here x times a constant).
TEST(Grid3, WithTwoPointsIsLinear) {
  const Grid3 grid = Sampled(2);
  const double low = grid.At({0.25, 0.5, 1.5}).value, high = grid.At({0.5, 0.5, 1.5}).value;
  EXPECT_NEAR(grid.At({0.375, 0.5, 1.5}).value, 0.5 * (low + high), 1e-12);
}

// Source: the header's promise; a fit that strays must neither run away nor be told of a slope that is not
// there.
TEST(Grid3, GoesOnFlatBeyondItsEnds) {
  const Grid3 grid = Sampled(6);
  const Grid3::Sample inside = grid.At({2.0, 0.5, 2.0}), beyond = grid.At({5.0, 0.5, 2.0});
  EXPECT_DOUBLE_EQ(beyond.value, inside.value);
  EXPECT_EQ(beyond.slope[0], 0.0);
  EXPECT_DOUBLE_EQ(beyond.slope[1], inside.slope[1]);
}

}  // namespace
}  // namespace dermap
