// SPDX-License-Identifier: Apache-2.0
// Error bars and flags.
#include "fit/uncertainty.h"

#include <gtest/gtest.h>

#include <cmath>

#include "fit/local_start.h"
#include "tests/fit/scene.h"

namespace dermap {
namespace {

double Scatter(const PlaneF& plane) {
  double sum = 0.0, squares = 0.0;
  for (float value : plane.values()) sum += value;
  const double mean = sum / static_cast<double>(plane.size());
  for (float value : plane.values()) squares += (value - mean) * (value - mean);
  return std::sqrt(squares / static_cast<double>(plane.size() - 1));
}

// Uniform skin, known noise, pixels that do not see each other: sigma must be the scatter of the maps over
// the pixels. 400 pixels give the scatter itself to 4 %; bounds and prior make it a little smaller than the
// linear theory.
TEST(Uncertainty, SigmaIsTheScatterOnUniformSkin) {
  const ForwardModel model = testing::MakeModel(testing::EightBands(), testing::Uniform(20.0));
  const ParameterVector truth{0.03, 0.5, 0.012, 0.02, 0.05};
  ReflectanceStack stack = testing::NoisyStack(model, ParameterMaps(20, 20, truth), 0.005, 6);
  const FitData data = testing::Prepared(stack);
  PatchProblem problem(data, model, ParameterSpace(testing::AllParameters()));
  const FitState state = problem.StateOf(InvertLocally(problem, AverageSkin()));
  const ParameterMaps sigma = StandardDeviations(problem, state);
  for (int i = 0; i < kParameterCount; ++i) {
    const double ratio = Scatter(state.maps.planes[i]) / sigma.planes[i](10, 10);
    EXPECT_GT(ratio, 0.7) << kParameters[i].name;
    EXPECT_LT(ratio, 1.2) << kParameters[i].name;
  }
}

// What is not free has no sigma, and no sigma exceeds what the range alone says, range / sqrt(12).
TEST(Uncertainty, SigmaIsBoundedByTheRange) {
  const ForwardModel model = testing::MakeModel(testing::FourBands(), testing::Uniform(0.3));
  ParameterVector dark = AverageSkin();
  dark[0] = 0.45;
  const ParameterMaps maps(4, 4, dark);
  const FitData data = testing::Prepared(testing::NoisyStack(model, maps, 0.05, 1), 2);
  PatchProblem problem(data, model, ParameterSpace({Parameter::kC_m, Parameter::kC_hd}));
  const ParameterMaps sigma = StandardDeviations(problem, problem.StateOf(maps));
  EXPECT_EQ(sigma[Parameter::kBeta_m](1, 1), 0.0f);
  EXPECT_GT(sigma[Parameter::kC_hd](1, 1), 0.9 * 0.1 / std::sqrt(12.0));
  EXPECT_LE(sigma[Parameter::kC_hd](1, 1), 1.0001 * 0.1 / std::sqrt(12.0));
}

// Deep blood under dark skin is beyond what 8 bands of 0.5 % noise tell (Cramer-Rao error of 2500 %), melanin
// is not.
TEST(Uncertainty, DeepBloodUnderDarkSkinIsNotIdentifiable) {
  const ForwardModel model = testing::MakeModel(testing::EightBands(), testing::Uniform(0.3));
  for (double melanin : {0.02, 0.3}) {
    ParameterVector skin = AverageSkin();
    skin[0] = melanin;
    const ParameterMaps maps(4, 4, skin);
    const FitData data = testing::Prepared(testing::NoisyStack(model, maps, 0.005, 1));
    PatchProblem problem(data, model, ParameterSpace(testing::AllParameters()));
    const FitState state = problem.StateOf(maps);
    const ParameterMaps sigma = StandardDeviations(problem, state);
    EXPECT_EQ((FlagsOf(problem, state, sigma)(1, 1) & kFlagNotIdentifiable) != 0, melanin > 0.2);
    EXPECT_LT(sigma[Parameter::kC_m](1, 1), 0.15 * melanin);
  }
}

// Each flag from a pixel made for it.
TEST(Uncertainty, FlagsNameWhatHappened) {
  const ForwardModel model = testing::MakeModel(testing::FourBands(), testing::Uniform(0.3));
  ParameterMaps maps(4, 4, AverageSkin());
  maps[Parameter::kC_hd](0, 0) = 0.1f;  // at its upper bound
  ReflectanceStack stack = testing::NoisyStack(model, maps, 0.005, 1);
  for (PlaneF& plane : stack.reflectance) plane(1, 0) *= 1.1f;  // 20 sigma off
  stack.reflectance[3](2, 0) = 0.95f;                           // no skin is that bright
  for (PlaneF& plane : stack.reflectance) plane(3, 0) = std::nanf("");
  const FitData data = testing::Prepared(stack, 2);
  PatchProblem problem(data, model, ParameterSpace({Parameter::kC_m, Parameter::kC_hd}));
  const FitState state = problem.StateOf(maps);
  const Plane<std::uint32_t> flags = FlagsOf(problem, state, StandardDeviations(problem, state));
  EXPECT_EQ(flags(0, 0), kFlagAtBound);
  EXPECT_EQ(flags(1, 0), kFlagNotConverged);
  EXPECT_EQ(flags(2, 0), kFlagNotConverged | kFlagOutsideValidity);
  EXPECT_EQ(flags(3, 0), kFlagSaturated);
  EXPECT_EQ(flags(2, 2), 0u);
}

}  // namespace
}  // namespace dermap
