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

// Algebra: (0.4 - 0.3996) / 0.004, and its slope against the logarithm, predicted / sigma.
TEST(Objective, LogResidualIsLinearNearTheSolution) {
  const LogResidual datum = LogResidualOf(0.4, 0.004, 0.3996);
  EXPECT_NEAR(datum.residual, 0.1, 1e-9);
  EXPECT_NEAR(datum.weight, 99.9, 1e-9);
}

// Statistics: the mean of unbiased noise asks for no change. In logarithms, weighted by the measured value,
// it would ask for 1.5 variances of it.
TEST(Objective, LogResidualOfNoiseIsUnbiased) {
  double residuals = 0.0, squares = 0.0;
  for (int i = -300; i <= 300; ++i) {  // a Gaussian by quadrature
    const double z = 0.01 * i, density = std::exp(-0.5 * z * z);
    residuals += density * LogResidualOf(0.3 * (1.0 + 0.1 * z), 0.03, 0.3).residual;
    squares += density;
  }
  EXPECT_NEAR(residuals / squares, 0.0, 1e-9);
}

// Differences: the slope is the derivative on both branches, and both meet.
TEST(Objective, LogResidualIsSmooth) {
  for (const double predicted : {0.05, 0.2, 0.3332, 0.3335, 0.4, 0.4998, 0.5002, 0.9}) {
    const double step = 1e-5;
    const double slope = (LogResidualOf(0.4, 0.004, predicted * std::exp(step)).residual -
                          LogResidualOf(0.4, 0.004, predicted * std::exp(-step)).residual) /
                         (2.0 * step);
    EXPECT_NEAR(-slope, LogResidualOf(0.4, 0.004, predicted).weight, 1e-4 * std::abs(slope)) << predicted;
  }
  EXPECT_NEAR(LogResidualOf(0.4, 0.004, 0.4 / 1.2 * (1 + 1e-9)).residual,
              LogResidualOf(0.4, 0.004, 0.4 / 1.2 * (1 - 1e-9)).residual, 1e-4);
}

// A negative datum of noise must not become a NaN.
TEST(Objective, LogResidualOfNoiseIsFinite) {
  const LogResidual datum = LogResidualOf(-0.002, 0.001, 0.0015);
  EXPECT_TRUE(std::isfinite(datum.residual));
  EXPECT_GT(datum.weight, 0.0);
  EXPECT_TRUE(std::isfinite(LogResidualOf(-0.2, 0.001, 0.3).residual));
}

}  // namespace
}  // namespace dermap
