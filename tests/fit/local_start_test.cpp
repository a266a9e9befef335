// SPDX-License-Identifier: Apache-2.0
// The closed-form inversion of single pixels.
#include "fit/local_start.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/fit/scene.h"

namespace dermap {
namespace {

// Exact data of uniform skin have one solution: the parameters that they were computed from. The prior may
// hold back no more than data of 0.1 % noise let it; what they hardly determine (carotene, deep blood under
// melanin) is looser.
TEST(LocalStart, RecoversUniformSkin) {
  const ForwardModel model = testing::MakeModel(testing::EightBands(), testing::Uniform(0.2));
  for (double melanin : {0.02, 0.1}) {
    const ParameterVector truth{melanin, 0.7, 0.008, 0.02, 0.04};
    ReflectanceStack stack = testing::NoisyStack(model, ParameterMaps(4, 4, truth), 0.001, 1);
    for (int b = 0; b < 8; ++b)
      for (float& value : stack.reflectance[b].values())
        value = static_cast<float>(model.LocalReflectance(b, truth, model.tissue().junction_absorbance));
    const FitData data = testing::Prepared(stack);
    const PatchProblem problem(data, model, ParameterSpace(testing::AllParameters()));
    const SkinPoint found = problem.PointAt(InvertLocally(problem, AverageSkin()), 5);
    EXPECT_NEAR(found[0], truth[0], 0.01 * truth[0]);
    EXPECT_NEAR(found[1], truth[1], 0.02);
    EXPECT_NEAR(found[2], truth[2], 0.05 * truth[2]);
    EXPECT_NEAR(found[3], truth[3], 0.10 * truth[3]);
    EXPECT_NEAR(found[4], truth[4], 0.10 * truth[4]);
  }
}

// A reflectance that no skin has leads to the bounds of table 1, not beyond and not to NaN.
TEST(LocalStart, RespectsBounds) {
  const ForwardModel model = testing::MakeModel(testing::FourBands(), testing::Uniform(0.2));
  for (float value : {1.2f, 1e-5f}) {
    ReflectanceStack stack = testing::NoisyStack(model, ParameterMaps(3, 3, AverageSkin()), 0.005, 1);
    for (PlaneF& plane : stack.reflectance) plane = PlaneF(3, 3, value);
    const FitData data = testing::Prepared(stack, 4);
    const PatchProblem problem(data, model, ParameterSpace(testing::AllParameters()));
    const SkinPoint found = problem.PointAt(InvertLocally(problem, AverageSkin()), 4);
    for (int i = 0; i < kParameterCount; ++i) {
      EXPECT_GE(found[i], kParameters[i].lower - 1e-9);
      EXPECT_LE(found[i], kParameters[i].upper + 1e-6);
    }
    EXPECT_NEAR(found[0], value > 1.0f ? 0.0 : 0.5, 1e-3);
  }
}

// One band tells one parameter: melanin by itself, the others staying at what they were fixed to.
TEST(LocalStart, OneBandTellsMelanin) {
  const ForwardModel model = testing::MakeModel({{560, 0}}, testing::Uniform(0.2));
  ParameterVector truth = AverageSkin();
  truth[0] = 0.11;
  ReflectanceStack stack = testing::NoisyStack(model, ParameterMaps(3, 3, truth), 0.002, 1);
  const double reflectance = model.LocalReflectance(0, truth, model.tissue().junction_absorbance);
  stack.reflectance[0] = PlaneF(3, 3, static_cast<float>(reflectance));
  const FitData data = testing::Prepared(stack, 1);
  const PatchProblem problem(data, model, ParameterSpace({Parameter::kC_m}));
  const SkinPoint found = problem.PointAt(InvertLocally(problem, AverageSkin()), 4);
  EXPECT_NEAR(found[0], 0.11, 0.001);
  EXPECT_FLOAT_EQ(static_cast<float>(found[4]), 0.03f);
}

}  // namespace
}  // namespace dermap
