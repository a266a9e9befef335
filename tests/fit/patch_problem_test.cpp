// SPDX-License-Identifier: Apache-2.0
// Renders, forward differences and the local Jacobian.
#include "fit/patch_problem.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/fit/scene.h"

namespace dermap {
namespace {

using testing::AllParameters;

// On uniform skin under light everywhere the forward differences of the full render must be the closed form's
// exact gradient. What remains is the cut of the series and the pyramid's rounding.
TEST(PatchProblem, ForwardDifferencesMatchTheClosedGradientOnUniformSkin) {
  const ForwardModel model = testing::MakeModel(testing::FourBands(), testing::Uniform(0.2));
  const ParameterMaps maps(8, 8, AverageSkin());
  const FitData data = testing::Prepared(testing::NoisyStack(model, maps, 0.005, 1), 4);
  PatchProblem problem(data, model, ParameterSpace(AllParameters()));
  const FitState state = problem.StateOf(maps);
  const DerivativePlanes derivatives = problem.ForwardDifferences(state, 1e-3);
  for (int b = 0; b < 4; ++b) {
    ParameterVector gradient;
    model.LocalReflectance(b, AverageSkin(), model.tissue().junction_absorbance, gradient);
    for (int j = 0; j < 5; ++j) {
      const double expected = gradient[j] * problem.space().scale(j);
      EXPECT_NEAR(derivatives[j][b](4, 4), expected, 0.02 * std::abs(expected) + 2e-4)
          << kParameters[j].name << " at " << data.bands[b].wavelength_nm << " nm";
    }
  }
}

// [D08 6.3]: one full render a parameter beside the one that they are compared with.
TEST(PatchProblem, CountsRenders) {
  const ForwardModel model = testing::MakeModel(testing::FourBands(), testing::Uniform(0.2));
  const ParameterMaps maps(6, 6, AverageSkin());
  const FitData data = testing::Prepared(testing::NoisyStack(model, maps, 0.005, 1), 4);
  PatchProblem problem(data, model, ParameterSpace(AllParameters()));
  const FitState state = problem.StateOf(maps);
  EXPECT_EQ(problem.renders(), 1);
  problem.ForwardDifferences(state, 1e-3);
  EXPECT_EQ(problem.renders(), 6);
}

// A parameter at its upper bound is lowered instead: the maps never leave table 1, and the derivative keeps
// its sign.
TEST(PatchProblem, DifferencesStayWithinTheUpperBound) {
  const ForwardModel model = testing::MakeModel(testing::FourBands(), testing::Uniform(0.2));
  ParameterVector full_blood = AverageSkin();
  full_blood[static_cast<int>(Parameter::kC_hd)] = 0.1;
  const ParameterMaps maps(6, 6, full_blood);
  const FitData data = testing::Prepared(testing::NoisyStack(model, maps, 0.005, 1), 4);
  PatchProblem problem(data, model, ParameterSpace({Parameter::kC_hd}));
  const DerivativePlanes derivatives = problem.ForwardDifferences(problem.StateOf(maps), 5e-3);
  ParameterVector gradient;
  model.LocalReflectance(2, full_blood, model.tissue().junction_absorbance, gradient);
  const double expected = gradient[static_cast<int>(Parameter::kC_hd)] * problem.space().scale(0);
  EXPECT_NEAR(derivatives[0][2](3, 3), expected, 0.03 * std::abs(expected));
}

}  // namespace
}  // namespace dermap
