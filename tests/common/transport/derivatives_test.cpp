// SPDX-License-Identifier: Apache-2.0
// Products with the render's Jacobian and with its transpose.
#include <gtest/gtest.h>

#include <cmath>

#include "common/core/parallel.h"
#include "tests/common/transport/derivative_cases.h"
#include "tests/common/transport/scenes.h"

namespace dermap {
namespace {

const Band kBands[] = {{450.0, 0.0}, {580.0, 10.0}, {650.0, 0.0}};
using Case = DerivativeCase;

// All one way, so that the mean is no difference of large numbers.
ParameterMaps OneWay(ParameterMaps change) {
  const auto up = [](PlaneF& plane) {
    for (float& value : plane.values()) value = std::abs(value);
  };
  for (PlaneF& plane : change.planes) up(plane);
  for (PlaneF& plane : change.junction_absorbance) up(plane);
  return change;
}

class Derivatives : public testing::TestWithParam<Case> {};

// Source: the definition of a transpose, <J v, w> = <v, J' w>, to rounding.
TEST_P(Derivatives, TransposeIsTheTranspose) {
  const ForwardModel model = ModelOf(GetParam(), kBands);
  const ParameterMaps maps = SceneOf(GetParam()), change = ChangeOf(maps, 20);
  EXPECT_LT(TransposeError(model, maps, change), 1e-5);
  const std::vector<PlaneF> once = model.Tangent(maps, change);
  const ForwardModel::Kept kept(model, maps);
  kept.Tangent(ChangeOf(maps, 30));
  const std::vector<PlaneF> again = kept.Tangent(change);  // whatever was asked before
  for (int b = 0; b < 3; ++b)
    for (std::size_t i = 0; i < again[b].size(); ++i)
      ASSERT_EQ(again[b].data()[i], once[b].data()[i]) << b << ' ' << i;
}

INSTANTIATE_TEST_SUITE_P(GaussianEngines, Derivatives,
                         testing::Values(Case{64, Illumination::kWindow, Tape::kFree, Coupling::kGather,
                                              false, BeneathTape::kEdge, Engine::kCascade},
                                         Case{50, Illumination::kUniform, Tape::kFree, Coupling::kGather,
                                              true, BeneathTape::kEdge, Engine::kCascade},
                                         Case{57, Illumination::kWindow, Tape::kBlack, Coupling::kGather,
                                              true, BeneathTape::kMean, Engine::kCascade},
                                         Case{64, Illumination::kWindow, Tape::kBlack, Coupling::kGather,
                                              true, BeneathTape::kEdge, Engine::kPyramid},
                                         Case{128, Illumination::kUniform, Tape::kFree, Coupling::kGather,
                                              false, BeneathTape::kEdge, Engine::kPyramid},
                                         Case{75, Illumination::kWindow, Tape::kFree, Coupling::kGather,
                                              false, BeneathTape::kMirrored, Engine::kPyramid}));

const Case kPathCases[] = {
    {128, Illumination::kWindow, Tape::kFree, Coupling::kReciprocal, false},
    {128, Illumination::kUniform, Tape::kFree, Coupling::kReciprocal, true},
    {100, Illumination::kWindow, Tape::kBlack, Coupling::kReciprocal, true},
    {90, Illumination::kWindow, Tape::kBlack, Coupling::kGather, false},
    {90, Illumination::kWindow, Tape::kFree, Coupling::kReciprocal, true, BeneathTape::kMean},
    {64, Illumination::kWindow, Tape::kFree, Coupling::kReciprocal, false, BeneathTape::kMirrored}};
INSTANTIATE_TEST_SUITE_P(Paths, Derivatives, testing::ValuesIn(kPathCases));

// Source: differences of the render. Single precision rounds each pixel of a render, so a pixel's difference
// is good to some 1e-5 of its value over the step; the mean over all pixels, where rounding averages out and
// an error of a derivative would not, to 2e-5.
TEST(DerivativesOfPaths, AreTheLimitOfDifferences) {
  for (const Case& c : kPathCases) {
    const ParameterMaps maps = SceneOf(c);
    for (const auto& [rms, mean] :
         ErrorsAgainstDifferences(ModelOf(c, kBands), maps, OneWay(ChangeOf(maps, 20)), 0.1)) {
      EXPECT_LT(rms, 3e-4) << c.size;
      EXPECT_LT(mean, 2e-5) << c.size;
    }
  }
}

// The engines made of Gaussians read tables that are linear between 256 absorptions: their render has a kink
// at each. Every pixel is moved to the middle between two, and never changed by as much as the way to them.
void StayBetweenEntries(const Absorbers& absorbers, ParameterMaps& maps, ParameterMaps& change) {
  const double step = std::log(TableMuA(1) / TableMuA(0)), first = std::log(TableMuA(0));
  const auto middle = [&](double mu_a) {
    return std::exp(first + (std::floor((std::log(mu_a) - first) / step) + 0.5) * step);
  };
  for (std::size_t i = 0; i < maps.planes[0].size(); ++i) {
    ParameterVector p, by;
    for (int k = 0; k < kParameterCount; ++k)
      p[k] = maps.planes[k].data()[i], by[k] = change.planes[k].data()[i];
    const double above = absorbers.MuAEpidermis(p), below = absorbers.MuADermis(p);
    const ParameterVector gradient_above = absorbers.MuAEpidermisGradient(p);
    const ParameterVector gradient_below = absorbers.MuADermisGradient(p);
    const int melanin = static_cast<int>(Parameter::kC_m), blood = static_cast<int>(Parameter::kC_hd);
    maps.planes[melanin].data()[i] += static_cast<float>((middle(above) - above) / gradient_above[melanin]);
    maps.planes[blood].data()[i] += static_cast<float>((middle(below) - below) / gradient_below[blood]);
    double change_above = 0.0, change_below = 0.0;
    for (int k = 0; k < kParameterCount; ++k)
      change_above += gradient_above[k] * by[k], change_below += gradient_below[k] * by[k];
    const double most = std::max({std::abs(change_above) / above, std::abs(change_below) / below, 1e-12});
    for (int k = 0; k < kParameterCount; ++k)
      change.planes[k].data()[i] *= static_cast<float>(std::min(1.0, step / 3.0 / most));
  }
}

// Source: as above, one wavelength at a time. What a filter or the source of the
// profiles adds is not of the engines, and tested above.
TEST(DerivativesOfGaussians, AreTheLimitOfDifferences) {
  for (const Engine engine : {Engine::kCascade, Engine::kPyramid}) {
    for (const Band& band : {Band{450.0, 0.0}, Band{580.0, 0.0}, Band{650.0, 0.0}}) {
      const Case c{64,   Illumination::kWindow, Tape::kBlack, Coupling::kGather,
                   true, BeneathTape::kMean,    engine};
      ParameterMaps maps = SceneOf(c), change = OneWay(ChangeOf(maps, 20));
      for (float& value : change.junction_absorbance[0].values()) value *= 0.1f;  // absorbance stays above 0
      StayBetweenEntries(TestChromophores().At(band.wavelength_nm, TissueConfig{}), maps, change);
      const DifferenceError error =
          ErrorsAgainstDifferences(ModelOf(c, {&band, 1}, "multipole"), maps, change, 0.7).front();
      EXPECT_LT(error.rms, 3e-4) << EngineName(engine) << ' ' << band.wavelength_nm;
      EXPECT_LT(error.mean, 1e-5) << EngineName(engine) << ' ' << band.wavelength_nm;
    }
  }
}

// Results do not depend on how many threads share the work.
TEST(DerivativesOfARender, AreTheSameForAnyNumberOfThreads) {
  for (const Engine engine : {Engine::kLowRank, Engine::kPyramid, Engine::kCascade}) {
    const Case c{64,    Illumination::kWindow, Tape::kFree, Coupling::kReciprocal,
                 false, BeneathTape::kEdge,    engine};
    const ForwardModel model = ModelOf(c, kBands);
    const ParameterMaps maps = SceneOf(c);
    const auto on = [&](int threads) {
      const ThreadLimit limit(threads);
      return model.Transpose(maps, [](int, const PlaneF& reflectance) { return reflectance; });
    };
    const ParameterMaps alone = on(1), shared = on(3);
    for (int k = 0; k < kParameterCount; ++k)
      for (std::size_t i = 0; i < alone.planes[k].size(); ++i)
        ASSERT_EQ(alone.planes[k].data()[i], shared.planes[k].data()[i]) << EngineName(engine);
  }
}

// Source: the slow twin. Both Gaussian engines are the same sum, so their derivatives are as close as
// renders.
TEST(DerivativesOfARender, OfThePyramidAreTheCascades) {
  Case c{64, Illumination::kWindow, Tape::kFree, Coupling::kGather, true};
  const ParameterMaps maps = SceneOf(c), change = OneWay(ChangeOf(maps, 20));
  c.engine = Engine::kCascade;
  const std::vector<PlaneF> slow = ModelOf(c, kBands).Tangent(maps, change);
  c.engine = Engine::kPyramid;
  const std::vector<PlaneF> fast = ModelOf(c, kBands).Tangent(maps, change);
  for (int b = 0; b < 3; ++b) EXPECT_LT(std::abs(Compare(fast[b], slow[b]).relative_rms), 2e-3) << b;
}

}  // namespace
}  // namespace dermap
