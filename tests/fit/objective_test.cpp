// SPDX-License-Identifier: Apache-2.0
// chi2, rms and residuals.
#include "fit/objective.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace dermap {
namespace {

FitData TwoBands() {
  FitData data;
  data.bands = {{500, 0}, {600, 0}};
  data.measured = {PlaneF(2, 1, 0.5f), PlaneF(2, 1, 0.4f)};
  data.sigma = {PlaneF(2, 1, 0.01f), PlaneF(2, 1, 0.02f)};
  data.flags = Plane<std::uint32_t>(2, 1);
  MarkFitted(data, 1);
  return data;
}

// By hand: residuals 0.02, 0.01 in the first band and 0.04, 0 in the second, over 0.01 and 0.02.
TEST(Objective, CountsSquaresOverNoise) {
  std::vector<PlaneF> predicted{PlaneF(2, 1), PlaneF(2, 1)};
  predicted[0](0, 0) = 0.48f;
  predicted[0](1, 0) = 0.49f;
  predicted[1](0, 0) = 0.36f;
  predicted[1](1, 0) = 0.40f;
  const Misfit misfit = Evaluate(TwoBands(), predicted);
  EXPECT_NEAR(misfit.chi2, 4 + 1 + 4 + 0, 1e-4);
  EXPECT_NEAR(misfit.chi2_map(0, 0), 8, 1e-4);
  EXPECT_EQ(misfit.data_count, 4u);
  EXPECT_NEAR(misfit.rms, std::sqrt((0.0004 + 0.0001 + 0.0016) / 4), 1e-7);
  EXPECT_NEAR(misfit.rms_per_band[0], std::sqrt(0.0005 / 2), 1e-7);
  EXPECT_NEAR(misfit.rms_per_band[1], std::sqrt(0.0016 / 2), 1e-7);
  EXPECT_NEAR(Residual(TwoBands(), predicted)[1](0, 0), 0.04, 1e-7);
}

// Missing data and pixels that are not fitted count for nothing, and stay NaN in the residual.
TEST(Objective, LeavesOutWhatIsMissing) {
  FitData data = TwoBands();
  data.measured[0](0, 0) = std::numeric_limits<float>::quiet_NaN();
  data.fitted(1, 0) = 0;
  const std::vector<PlaneF> predicted{PlaneF(2, 1, 0.1f), PlaneF(2, 1, 0.36f)};
  const Misfit misfit = Evaluate(data, predicted);
  EXPECT_EQ(misfit.data_count, 1u);
  EXPECT_NEAR(misfit.chi2, 4, 1e-4);
  EXPECT_EQ(misfit.rms_per_band[0], 0.0);
  EXPECT_TRUE(std::isnan(Residual(data, predicted)[0](0, 0)));
}

// Taylor: near the solution the logarithm's residual over its noise is (measured - predicted) / sigma.
TEST(Objective, LogResidualAgreesNearTheSolution) {
  const LogResidual datum = LogResidualOf(0.4, 0.004, 0.3996);
  EXPECT_NEAR(datum.residual, 0.1, 1e-4);
  EXPECT_NEAR(datum.weight, 100, 1e-9);
}

// A negative datum of noise must not become a NaN.
TEST(Objective, LogResidualOfNoiseIsFinite) {
  const LogResidual datum = LogResidualOf(-0.002, 0.001, 0.0015);
  EXPECT_TRUE(std::isfinite(datum.residual));
  EXPECT_NEAR(datum.weight, 1.0, 1e-9);
}

}  // namespace
}  // namespace dermap
