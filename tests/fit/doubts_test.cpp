// SPDX-License-Identifier: Apache-2.0
// What a fit is told against what the scene was made with. Scene and fit share the forward model but for that
// one value, so what is on trial is whether the wrong value is seen and sigma holds what it does.
#include "fit/doubts.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/optics/profile_source.h"
#include "fit/fast.h"
#include "tests/fit/scene.h"

namespace dermap {
namespace {

constexpr double kPixel_mm = 7.5 / 32;

ForwardModel ModelOf(const ImagingConditions& conditions, double thickness_mm) {
  TissueConfig tissue;
  tissue.epidermis_thickness_mm = thickness_mm;
  return {testing::TestChromophores(),
          *MakeProfileSource("exact"),
          tissue,
          testing::EightBands(),
          conditions,
          {}};
}

// Skin of 32 x 32 pixels in a window, fitted with a pixel size and a thickness over the true ones.
FastOutcome FitTold(double pixel_size, double thickness) {
  TissueConfig truth;
  const ForwardModel model = ModelOf(testing::Window(kPixel_mm), truth.epidermis_thickness_mm);
  ReflectanceStack stack = testing::NoisyStack(model, testing::SpottedSkin(32, 0.06), 0.005, 9);
  stack.pixel_size_mm = pixel_size * kPixel_mm;
  FitData data = testing::Prepared(stack);
  const ForwardModel told = ModelOf(data.conditions, thickness * truth.epidermis_thickness_mm);
  const ModelMaker maker = [&](const ImagingConditions& conditions) { return told.With(conditions); };
  FitOptions options;
  RunLog log;
  return FitCoarseToFine(data, told, {}, maker, options, log);
}

const Doubt* Find(const FastOutcome& fit, Assumption assumption) {
  const auto found = std::find_if(fit.doubts.all().begin(), fit.doubts.all().end(),
                                  [&](const Doubt& doubt) { return doubt.assumption == assumption; });
  return found == fit.doubts.all().end() ? nullptr : &*found;
}

TEST(Doubts, NothingIsDoubtedThatIsRight) {
  const FastOutcome fit = FitTold(1.0, 1.0);
  for (const Doubt& doubt : fit.doubts.all())
    EXPECT_LT(doubt.probability, 0.05)
        << static_cast<int>(doubt.assumption) << ' ' << doubt.log_error << ' ' << doubt.sigma;
}

TEST(Doubts, AWrongPixelSizeIsSeen) {
  for (const double told : {0.8, 1.25}) {
    const FastOutcome fit = FitTold(told, 1.0);
    const Doubt* doubt = Find(fit, Assumption::kPixelSize);
    ASSERT_TRUE(doubt) << told;
    EXPECT_GT(doubt->probability, 0.9) << told;
    EXPECT_NEAR(doubt->log_error, -std::log(told), 0.12) << told;
  }
}

TEST(Doubts, AWrongThicknessIsSeen) {
  const FastOutcome fit = FitTold(1.0, 0.85);
  const Doubt* doubt = Find(fit, Assumption::kThickness);
  ASSERT_TRUE(doubt);
  EXPECT_GT(doubt->probability, 0.9);
  EXPECT_NEAR(doubt->log_error, -std::log(0.85), 0.08);
}

// A fifth of the pixel size or of the thickness moves the maps by more than the noise does; their intervals
// must follow.
TEST(Doubts, SigmaHoldsWhatAWrongValueChanges) {
  for (const auto& [pixel, thickness] : {std::pair{1.2, 1.0}, std::pair{1.0, 0.85}}) {
    const FastOutcome fit = FitTold(pixel, thickness);
    const ParameterMaps truth = testing::SpottedSkin(32, 0.06);
    const ParameterSpace space(fit.free);
    for (int j = 0; j < space.count(); ++j) {
      if (space.parameter(j) == Parameter::kJunctionAbsorbance) continue;  // not of these scenes
      double covered = 0.0;
      const PlaneF& found = fit.state.maps.Unknown(space.parameter(j));
      for (std::size_t i = 0; i < found.size(); ++i) {
        const double error = (found.data()[i] - truth.Unknown(space.parameter(j)).data()[i]) / space.scale(j);
        covered += std::abs(error) < 1.96 * std::sqrt(fit.variance[j].data()[i]);
      }
      EXPECT_GT(covered / static_cast<double>(found.size()), 0.9)
          << pixel << ' ' << thickness << ' ' << InfoOf(space.parameter(j)).name;
    }
  }
}

// Black tape is what the pixel size is known from.
TEST(Doubts, BlackTapeIsNotAskedAgain) {
  const ForwardModel model = testing::MakeModel(testing::EightBands(), testing::Window(kPixel_mm));
  ReflectanceStack stack = testing::NoisyStack(model, testing::SpottedSkin(32, 0.06), 0.005, 9);
  stack.tape = Tape::kBlack;
  FitData data = testing::Prepared(stack);
  const ForwardModel black = model.With(data.conditions);
  const ModelMaker maker = [&](const ImagingConditions& conditions) { return black.With(conditions); };
  FitOptions options;
  RunLog log;
  EXPECT_FALSE(Find(FitCoarseToFine(data, black, {}, maker, options, log), Assumption::kPixelSize));
}

}  // namespace
}  // namespace dermap
