// SPDX-License-Identifier: Apache-2.0
// Cramer-Rao's bound against what its definition says of it.
#include "studies/noise_bound.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "studies/stability_bench.h"
#include "studies/study_scenes.h"

namespace dermap {
namespace {

class NoiseBoundOfFreckles : public ::testing::Test {
 protected:
  ParameterVector Bound(double factor, int without_band = -1) {
    std::vector<PlaneF> noise = known_.stack.sigma;
    for (int b = 0; b < static_cast<int>(noise.size()); ++b)
      for (float& value : noise[b].values())
        value =
            b == without_band ? std::numeric_limits<float>::quiet_NaN() : static_cast<float>(value * factor);
    return PixelNoiseBound(model_, known_.truth, noise, 0);
  }
  static KnownStack Noisy(KnownStack known) {
    AddNoise(known.stack, 1e-4, 1);
    return known;
  }
  StabilityBench bench_{16, 1000};
  KnownStack known_ = Noisy(bench_.Freckled(StudyBands()));
  ForwardModel model_ = bench_.ModelFor(known_.stack, {});
};

// Where data are far better than the range, bounds are proportional to noise; where they tell nothing, the
// range's own sigma is left.
TEST_F(NoiseBoundOfFreckles, GoesFromTheNoiseToTheRange) {
  const ParameterVector one = Bound(1.0), half = Bound(0.5), none = Bound(1e9);
  for (int k = 0; k < kParameterCount; ++k) {
    EXPECT_NEAR(one[k] / half[k], 2.0, 0.01) << k;
    EXPECT_NEAR(none[k] * std::sqrt(12.0), kParameters[k].upper - kParameters[k].lower, 1e-4) << k;
  }
}

TEST_F(NoiseBoundOfFreckles, AMissingBandIsNoDatum) {
  const ParameterVector all = Bound(1.0), seven = Bound(1.0, 7);
  for (int k = 0; k < kParameterCount; ++k) EXPECT_GT(seven[k], all[k]) << k;
}

// Of 0, 1, ... 9: the middle one, and the one above nine of them.
TEST(Quantiles, CountFromBelow) {
  const std::vector<double> values{9, 1, 8, 2, 7, 3, 6, 4, 5, 0};
  EXPECT_EQ(MedianOrNaN(values), 5.0);
  EXPECT_EQ(QuantileOrNaN(values, 0.9), 9.0);
  EXPECT_TRUE(std::isnan(MedianOrNaN({})));
}

}  // namespace
}  // namespace dermap
