// SPDX-License-Identifier: Apache-2.0
// Bands with a wrong gain are found, named and set right; honest ones are left alone.
#include "fit/band_check.h"

#include <gtest/gtest.h>

#include "fit/fast.h"
#include "tests/fit/scene.h"

namespace dermap {
namespace {

FastOutcome FitWithGain(double melanin, int band, double gain) {
  const ForwardModel model = testing::MakeModel(testing::EightBands(), testing::Window(7.5 / 32));
  ReflectanceStack stack = testing::NoisyStack(model, testing::SpottedSkin(32, melanin), 0.005, 9);
  for (float& value : stack.reflectance[band].values()) value *= static_cast<float>(gain);
  FitData data = testing::Prepared(stack);
  const ModelMaker maker = [](const ImagingConditions& conditions) {
    return testing::MakeModel(testing::EightBands(), conditions);
  };
  FitOptions options;
  RunLog log;
  return FitCoarseToFine(data, model, {}, maker, options, log);
}

TEST(BandCheck, HonestBandsAreLeftAlone) {
  for (const double melanin : {0.03, 0.08, 0.3})
    EXPECT_FALSE(FitWithGain(melanin, 0, 1.0).suspect) << melanin;
}

// Bands that one of the pigments alone decides can hide an error in it: those between are the ones that
// others vouch for.
TEST(BandCheck, AWrongGainIsFoundAndNamed) {
  for (const double gain : {1.02, 0.95, 1.25}) {
    const FastOutcome fit = FitWithGain(0.05, 3, gain);
    ASSERT_TRUE(fit.suspect) << gain;
    EXPECT_EQ(fit.suspect->band, 3) << gain;
    EXPECT_NEAR(fit.suspect->gain_error, gain - 1.0, 0.012) << gain;
    const ParameterMaps truth = testing::SpottedSkin(32, 0.05);
    EXPECT_LT(testing::MedianRelativeError(fit.state.maps[Parameter::kC_m], truth[Parameter::kC_m]), 0.04)
        << gain;
  }
}

}  // namespace
}  // namespace dermap
