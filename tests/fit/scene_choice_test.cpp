// SPDX-License-Identifier: Apache-2.0
// What the evidence frees, on scenes made to need it or not.
#include "fit/scene_choice.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "fit/fast.h"
#include "tests/fit/scene.h"

namespace dermap {
namespace {

using ::testing::Contains;
using ::testing::Not;

FastOutcome FitOf(const ParameterMaps& truth, const std::vector<Band>& bands, double noise = 0.005) {
  const ForwardModel model = testing::MakeModel(bands, testing::Window(7.5 / truth.width()));
  FitData data =
      testing::Prepared(testing::NoisyStack(model, truth, noise, 3), std::min<int>(5, bands.size()));
  const ModelMaker maker = [&](const ImagingConditions& conditions) {
    return testing::MakeModel(bands, conditions);
  };
  FitOptions options;
  RunLog log;
  return FitCoarseToFine(data, model, {}, maker, options, log);
}

TEST(SceneChoice, WhatVariesIsFreed) {
  const FastOutcome fit = FitOf(testing::SpottedSkin(32, 0.05), testing::EightBands());
  for (const Parameter p : testing::AllParameters()) EXPECT_THAT(fit.free, Contains(p)) << InfoOf(p).name;
  EXPECT_THAT(fit.free, Not(Contains(Parameter::kJunctionAbsorbance)));
}

TEST(SceneChoice, WithoutCaroteneNoneIsFreed) {
  ParameterMaps truth = testing::SpottedSkin(32, 0.05);
  for (float& value : truth[Parameter::kC_bc].values()) value = 0.0f;
  const FastOutcome fit = FitOf(truth, testing::EightBands());
  EXPECT_THAT(fit.free, Not(Contains(Parameter::kC_bc)));
  EXPECT_THAT(fit.candidates.front().absent, Contains(Parameter::kC_bc));
  EXPECT_EQ(fit.state.maps[Parameter::kC_bc](9, 9), 0.0f);
}

TEST(SceneChoice, AtAverageSkinsCaroteneNoneIsFreed) {
  ParameterMaps truth = testing::SpottedSkin(32, 0.05);
  for (float& value : truth[Parameter::kC_bc].values()) value = 0.01f;
  const FastOutcome fit = FitOf(truth, testing::EightBands());
  EXPECT_THAT(fit.free, Not(Contains(Parameter::kC_bc)));
  EXPECT_FLOAT_EQ(fit.state.maps[Parameter::kC_bc](9, 9), 0.01f);
}

TEST(SceneChoice, ATattooFreesTheJunction) {
  ParameterMaps truth = testing::SpottedSkin(32, 0.05);
  truth.junction_absorbance = {PlaneF(32, 32, 0.0175f)};
  for (int y = 8; y < 20; ++y)
    for (int x = 6; x < 14; ++x) truth.junction_absorbance[0](x, y) = 0.4f;
  const FastOutcome fit = FitOf(truth, testing::EightBands());
  EXPECT_THAT(fit.free, Contains(Parameter::kJunctionAbsorbance));
  EXPECT_NEAR(fit.state.maps.junction_absorbance[0](10, 14), 0.4, 0.1);
  EXPECT_NEAR(fit.state.maps.junction_absorbance[0](28, 5), 0.0175, 0.05);
}

// And the error bars say how far what is held fixed may be off.
TEST(SceneChoice, ThreeBandsFreeThreeAtMost) {
  const std::vector<Band> bands{{450, 0}, {540, 0}, {620, 0}};
  const ParameterMaps truth = testing::SpottedSkin(32, 0.05);
  const FastOutcome fit = FitOf(truth, bands);
  ASSERT_LE(fit.free.size(), 3u);
  const ParameterSpace space(fit.free);
  int held = 0, pixels = 0;
  for (int j = 0; j < space.count(); ++j) {
    const PlaneF& found = fit.state.maps.Unknown(fit.free[j]);
    for (std::size_t i = 0; i < found.size(); ++i, ++pixels) {
      const double error = (found.data()[i] - truth.Unknown(fit.free[j]).data()[i]) / space.scale(j);
      held += error * error < 1.96 * 1.96 * fit.variance[j].data()[i];
    }
  }
  EXPECT_GT(held, 0.9 * pixels);
}

}  // namespace
}  // namespace dermap
