// SPDX-License-Identifier: Apache-2.0
// Reduction and enlargement.
#include "fit/resample.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace dermap {
namespace {

FitData Data(int width, int height) {
  FitData data;
  data.bands = {{500, 0}};
  data.conditions.pixel_size_mm = 0.1;
  data.measured = {PlaneF(width, height)};
  data.sigma = {PlaneF(width, height, 0.02f)};
  data.flags = Plane<std::uint32_t>(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) data.measured[0](x, y) = static_cast<float>(x + 10 * y);
  MarkFitted(data, 1);
  return data;
}

// Means of 2 x 2 blocks and sigma / sqrt(4), by hand.
TEST(ReduceData, AveragesBlocksAndPropagatesNoise) {
  const FitData reduced = ReduceData(Data(4, 4), 2, 1);
  ASSERT_EQ(reduced.width(), 2);
  EXPECT_NEAR(reduced.measured[0](0, 0), (0 + 1 + 10 + 11) / 4.0, 1e-6);
  EXPECT_NEAR(reduced.measured[0](1, 1), (22 + 23 + 32 + 33) / 4.0, 1e-6);
  EXPECT_NEAR(reduced.sigma[0](1, 0), 0.01, 1e-8);
  EXPECT_NEAR(reduced.conditions.pixel_size_mm, 0.2, 1e-12);
}

// Area overlap by hand: 3 pixels to 2, the middle one shared in halves. Weights 1 and 1/2.
TEST(ReduceData, SharesPixelsThatStraddle) {
  const FitData reduced = ReduceData(Data(3, 3), 2, 1);
  EXPECT_NEAR(reduced.measured[0](0, 0), ((0 + 0.5 * 1) + 0.5 * (10 + 0.5 * 11)) / 2.25, 1e-6);
  EXPECT_NEAR(reduced.sigma[0](0, 0), 0.02 * 1.25 / 2.25, 1e-8);  // sqrt(sum of w^2) / sum of w
}

// Missing data carry no weight; less than half known is missing.
TEST(ReduceData, MissingDataCarryNoWeight) {
  FitData data = Data(4, 4);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  data.measured[0](0, 0) = data.sigma[0](0, 0) = nan;
  for (int i : {0, 1}) data.measured[0](2 + i, 0) = data.measured[0](2, 1) = nan;
  MarkFitted(data, 1);
  const FitData reduced = ReduceData(data, 2, 1);
  EXPECT_NEAR(reduced.measured[0](0, 0), (1 + 10 + 11) / 3.0, 1e-6);
  EXPECT_NEAR(reduced.sigma[0](0, 0), 0.02 / std::sqrt(3.0), 1e-8);
  EXPECT_TRUE(std::isnan(reduced.measured[0](1, 0)));
  EXPECT_EQ(reduced.fitted(1, 0), 0);
  EXPECT_EQ(reduced.fitted(0, 0), 1);
}

// Pixels stay square in a patch that is not, and asking for more than there is changes nothing.
TEST(ReduceData, KeepsPixelsSquareAndNeverEnlarges) {
  const FitData reduced = ReduceData(Data(12, 6), 4, 1);
  EXPECT_EQ(reduced.width(), 4);
  EXPECT_EQ(reduced.height(), 2);
  EXPECT_NEAR(reduced.conditions.pixel_size_mm, 0.3, 1e-12);
  EXPECT_EQ(ReduceData(Data(4, 4), 9, 1).width(), 4);
}

// Independent errors add in squares, by hand: 0.02 of noise and 0.002 * 11 of reduction.
TEST(ReduceData, ReductionErrorWidensSigma) {
  FitData data = Data(4, 4);
  AddRelativeError(data, kReductionError);
  EXPECT_NEAR(data.sigma[0](1, 1), std::hypot(0.02, 0.022), 1e-7);
  EXPECT_NEAR(data.sigma[0](0, 0), 0.02, 1e-7);
}

// Linear interpolation reproduces a ramp between the outer centres, and a constant everywhere.
TEST(ResizeLinear, KeepsRampsAndConstants) {
  PlaneF ramp(4, 3);
  for (int y = 0; y < 3; ++y)
    for (int x = 0; x < 4; ++x) ramp(x, y) = static_cast<float>(x + 0.5);
  const PlaneF large = ResizeLinear(ramp, 8, 6);
  for (int x = 1; x < 7; ++x) EXPECT_NEAR(large(x, 2), (x + 0.5) / 2.0, 1e-6);
  const PlaneF constant = ResizeLinear(PlaneF(3, 3, 0.7f), 7, 5);
  for (float value : constant.values()) EXPECT_FLOAT_EQ(value, 0.7f);
}

}  // namespace
}  // namespace dermap
