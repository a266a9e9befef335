// SPDX-License-Identifier: Apache-2.0
// Look-ups in a table of weights: its ends, interpolation and derivatives.
#include "common/optics/profile_table.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace dermap {
namespace {

// Entry j holds weight j in Gaussian 3 and 1 in Gaussian 5.
ProfileTable Ramp() {
  std::vector<GaussianWeights> entries(kTableSize);
  for (int j = 0; j < kTableSize; ++j) {
    entries[j][3] = static_cast<float>(j);
    entries[j][5] = 1.0f;
  }
  return ProfileTable(std::move(entries));
}

// 0.005 to 200 per mm in 256 logarithmic steps: 1/mm lies 255 ln(200)/ln(40000) = 127.5 steps up, by
// symmetry.
TEST(ProfileTable, IsLogarithmicInMuA) {
  EXPECT_NEAR(TableMuA(0), 0.005, 1e-15);
  EXPECT_NEAR(TableMuA(255), 200.0, 1e-9);
  EXPECT_NEAR(TableMuA(127) * TableMuA(128), 1.0, 1e-12);
  const auto middle = PositionInTable(1.0f);
  EXPECT_NEAR(middle.index + middle.fraction, 127.5, 1e-4);
  for (int j = 0; j < kTableSize; ++j) {
    const auto at = PositionInTable(static_cast<float>(TableMuA(j)));
    EXPECT_NEAR(at.index + at.fraction, j, 1e-4);
    EXPECT_TRUE(at.index >= 0 && at.index <= kTableSize - 2 && at.fraction >= 0.0f && at.fraction <= 1.0f);
  }
}

// The position is the value of a ramp; the other weight is 1 everywhere.
TEST(ProfileTable, InterpolatesLinearlyInLogMuA) {
  const auto table = Ramp();
  for (const double position : {0.0, 0.25, 17.5, 127.5, 254.75}) {
    const double mu_a = 0.005 * std::pow(40000.0, position / 255.0);
    std::array<float, kGaussianCount> weights{};
    table.Weights(static_cast<float>(mu_a), weights);
    EXPECT_NEAR(weights[3], position, 2e-3);
    EXPECT_NEAR(weights[5], 1.0f, 1e-6);
    EXPECT_EQ(weights[0], 0.0f);
    EXPECT_EQ(table.Weight(3, static_cast<float>(mu_a)), weights[3]);
    EXPECT_NEAR(table.Total(static_cast<float>(mu_a)), position + 1.0, 2e-3);
  }
}

// d position / d mu_a = 255 / (ln(40000) mu_a) by the rule of the logarithm.
TEST(ProfileTable, DerivativeIsThatOfTheInterpolation) {
  const auto table = Ramp();
  for (const float mu_a : {0.1f, 1.0f, 30.0f}) {
    EXPECT_NEAR(table.TotalDerivative(mu_a), 255.0 / (std::log(40000.0) * mu_a), 1e-3 / mu_a);
  }
}

// Clamped, never out of bounds: below, above, negative, infinite and not a number.
TEST(ProfileTable, ClampsWhatLiesOutside) {
  const auto table = Ramp();
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  for (const float mu_a : {0.0f, -1.0f, 0.001f, -kInfinity, std::numeric_limits<float>::quiet_NaN()}) {
    EXPECT_EQ(table.Total(mu_a), 1.0f);
    EXPECT_EQ(table.Weight(3, mu_a), 0.0f);
    EXPECT_EQ(table.TotalDerivative(mu_a), 0.0f);
  }
  for (const float mu_a : {200.0f, 1e9f, kInfinity}) {
    EXPECT_NEAR(table.Total(mu_a), 256.0f, 1e-3);
    EXPECT_NEAR(table.Weight(3, mu_a), 255.0f, 1e-3);
    EXPECT_EQ(table.TotalDerivative(mu_a), 0.0f);
  }
}

}  // namespace
}  // namespace dermap
