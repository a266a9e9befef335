// SPDX-License-Identifier: Apache-2.0
// The coarse-to-fine fit. Scene and fit share the forward model: the optimiser is on trial, not the physics.
#include "fit/fast.h"

#include <gtest/gtest.h>

#include "tests/fit/scene.h"

namespace dermap {
namespace {

class FastTest : public ::testing::Test {
 protected:
  FastTest()
      : model_(testing::MakeModel(testing::EightBands(), testing::Window(7.5 / 32))),
        truth_(testing::SpottedSkin(32, 0.05)),
        data_(testing::Prepared(testing::NoisyStack(model_, truth_, 0.005, 5))) {}

  FastOutcome Fit(const std::vector<int>* steps = nullptr) {
    return FitCoarseToFine(data_, model_, space_, maker_, options_, log_, steps);
  }

  ForwardModel model_;
  ParameterMaps truth_;
  FitData data_;
  ParameterSpace space_{testing::AllParameters()};
  FitOptions options_;
  RunLog log_;
  const ModelMaker maker_ = [](const ImagingConditions& conditions) {
    return testing::MakeModel(testing::EightBands(), conditions);
  };
};

// The noise that was added is the level that a fit can reach.
TEST_F(FastTest, ReachesTheNoiseInFewRenders) {
  const FastOutcome outcome = Fit();
  EXPECT_TRUE(outcome.converged);
  EXPECT_LT(outcome.state.misfit.Chi2PerDegree(5), 1.3);
  EXPECT_LE(log_.renders_before, 15);
  EXPECT_LT(testing::MedianRelativeError(outcome.state.maps[Parameter::kC_m], truth_[Parameter::kC_m]), 0.06);
  EXPECT_LT(testing::MedianRelativeError(outcome.state.maps[Parameter::kBeta_m], truth_[Parameter::kBeta_m]),
            0.15);
}

// Replaying the steps of a fit on the same data must give the same maps, bit for bit.
TEST_F(FastTest, StepsReplay) {
  const FastOutcome first = Fit();
  const FastOutcome again = Fit(&first.steps);
  for (std::size_t i = 0; i < truth_[Parameter::kC_m].size(); ++i)
    ASSERT_EQ(first.state.maps[Parameter::kC_m].data()[i], again.state.maps[Parameter::kC_m].data()[i]);
}

// Between nothing and as many parameters as are free in each pixel; a fit that ignored its data would count
// 0.
TEST_F(FastTest, AdaptedParametersLieBetweenNoneAndAllThatAreFree) {
  const FastOutcome outcome = Fit();
  const double adapted = AdaptedParameters(data_, model_, space_, maker_, options_, outcome, log_);
  EXPECT_GT(adapted, 1.0 * 32 * 32);
  EXPECT_LT(adapted, 5.0 * 32 * 32);
}

// With every pixel by itself (uniform light, one parameter, pixels far larger than light spreads) the count
// is that of linear regression: one parameter a pixel, however many bands. Prior and damping take a little
// away.
TEST(Fast, AdaptedParametersOfIndependentPixelsAreTheFreeOnes) {
  const ForwardModel model = testing::MakeModel(testing::FourBands(), testing::Uniform(20.0));
  const FitData data =
      testing::Prepared(testing::NoisyStack(model, ParameterMaps(16, 16, AverageSkin()), 0.005, 4), 1);
  const ParameterSpace space({Parameter::kC_m});
  FitOptions options;
  options.stop_chi2 = 0.0;
  RunLog log;
  const ModelMaker maker = [](const ImagingConditions& conditions) {
    return testing::MakeModel(testing::FourBands(), conditions);
  };
  const FastOutcome outcome = FitCoarseToFine(data, model, space, maker, options, log);
  const double adapted = AdaptedParameters(data, model, space, maker, options, outcome, log);
  EXPECT_NEAR(adapted / (16 * 16), 1.0, 0.15);
}

}  // namespace
}  // namespace dermap
