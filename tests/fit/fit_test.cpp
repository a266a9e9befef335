// SPDX-License-Identifier: Apache-2.0
// Whole fits of small stacks. Scene and fit share the forward model: the optimiser is on trial, not the
// physics.
#include "fit/fit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "common/core/error.h"
#include "tests/fit/scene.h"

namespace dermap {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

// Default options, a stack of 32^2 from simulated light skin: rms below 4 % [D08 6.4] by far, chi2 about 1,
// melanin within 10 % in the median pixel.
TEST(FitStack, FitsSimulatedSkinByDefault) {
  const ForwardModel model = testing::MakeModel(testing::EightBands(), testing::Window(7.5 / 32));
  const ParameterMaps truth = testing::SpottedSkin(32, 0.03);
  const FitResult result =
      FitStack(testing::NoisyStack(model, truth, 0.005, 8), FitOptions{}, testing::TestChromophores());
  EXPECT_TRUE(result.converged);
  EXPECT_EQ(result.method, "fast");
  EXPECT_EQ(result.free_parameters.size(), 5u);
  EXPECT_LT(result.rms_residual, 0.01);
  EXPECT_GT(result.chi2, 0.5);
  EXPECT_LT(result.chi2, 1.5);
  EXPECT_LT(result.degrees_of_freedom, static_cast<double>(result.data_count));
  EXPECT_LT(testing::MedianRelativeError(result.maps[Parameter::kC_m], truth[Parameter::kC_m]), 0.1);
  for (int b = 0; b < 8; ++b) {
    EXPECT_FLOAT_EQ(result.measured[b](3, 4) - result.predicted[b](3, 4), result.residual[b](3, 4));
    EXPECT_GT(result.noise[b](3, 4), 0.0f);
  }
  EXPECT_EQ(result.history.back().renders <= result.renders, true);
}

// Pixels that were masked do not disturb the others, are flagged, and get their neighbours' mean.
TEST(FitStack, MaskedPixelsAreFilledAndFlagged) {
  const ForwardModel model = testing::MakeModel(testing::EightBands(), testing::Window(7.5 / 16));
  const ParameterMaps truth = testing::SpottedSkin(16, 0.05);
  ReflectanceStack stack = testing::NoisyStack(model, truth, 0.005, 8);
  stack.valid = PlaneF(16, 16, 1.0f);
  for (int y = 5; y < 8; ++y)
    for (int x = 5; x < 8; ++x) {
      stack.valid(x, y) = 0.0f;
      for (PlaneF& plane : stack.reflectance) plane(x, y) = 1.4f;  // glare: would wreck its surroundings
    }
  FitOptions options;
  options.method = FitMethod::kDescent;
  options.start = StartPoint::kLocal;
  const FitResult result = FitStack(stack, options, testing::TestChromophores());
  EXPECT_TRUE(result.flags(6, 6) & kFlagSaturated);
  EXPECT_TRUE(std::isnan(result.residual[0](6, 6)));
  EXPECT_EQ(result.data_count, (256u - 9u) * 8u);
  EXPECT_NEAR(result.maps[Parameter::kC_m](6, 6), truth[Parameter::kC_m](6, 6), 0.02);
  EXPECT_LT(result.chi2_per_datum, 1.1);
  EXPECT_LT(testing::MedianRelativeError(result.maps[Parameter::kC_m], truth[Parameter::kC_m]), 0.1);
}

// One band frees one parameter, and says so.
TEST(FitStack, OneBandFitsMelaninAlone) {
  const ForwardModel model = testing::MakeModel({{560, 0}}, testing::Window(7.5 / 16));
  ParameterMaps truth(16, 16, AverageSkin());
  for (int i = 0; i < 256; ++i) truth[Parameter::kC_m].data()[i] = 0.05f + 0.0001f * static_cast<float>(i);
  const FitResult result =
      FitStack(testing::NoisyStack(model, truth, 0.002, 8), FitOptions{}, testing::TestChromophores());
  EXPECT_THAT(result.free_parameters, ElementsAre(Parameter::kC_m));
  EXPECT_THAT(result.decisions, Contains(HasSubstr("The evidence asks for C_m to be free")));
  EXPECT_FLOAT_EQ(result.maps[Parameter::kC_hd](3, 3), 0.03f);
  EXPECT_EQ(result.sigma[Parameter::kC_hd](3, 3), 0.0f);
  EXPECT_LT(testing::MedianRelativeError(result.maps[Parameter::kC_m], truth[Parameter::kC_m]), 0.05);
}

// A size that is asked for is kept, the pixel grows with it, and the choice is recorded.
TEST(FitStack, ReducesToTheSizeAskedFor) {
  const ForwardModel model = testing::MakeModel(testing::FourBands(), testing::Window(7.5 / 24));
  FitOptions options;
  options.size = 12;
  options.free_parameters = {Parameter::kC_m, Parameter::kC_hd};
  options.method = FitMethod::kDescent;
  options.max_iterations = 1;
  const FitResult result = FitStack(testing::NoisyStack(model, testing::SpottedSkin(24, 0.05), 0.005, 1),
                                    options, testing::TestChromophores());
  EXPECT_EQ(result.maps.width(), 12);
  EXPECT_NEAR(result.conditions.pixel_size_mm, 7.5 / 12, 1e-9);
  EXPECT_THAT(result.decisions, Contains(HasSubstr("at 12 pixels along the longer side, as asked for")));
  EXPECT_FALSE(result.converged);  // one iteration is not enough: a result, not an exception
  EXPECT_THAT(result.decisions, Contains(HasSubstr("Stopped after the 1 iterations allowed")));
}

// Every iteration writes only its own outputs: the number of threads changes nothing, to the last bit.
TEST(FitStack, ThreadsDoNotChangeTheResult) {
  const ForwardModel model = testing::MakeModel(testing::FourBands(), testing::Window(7.5 / 16));
  const ReflectanceStack stack = testing::NoisyStack(model, testing::SpottedSkin(16, 0.05), 0.005, 1);
  FitOptions options;
  options.free_parameters = {Parameter::kC_m, Parameter::kC_hd};
  options.threads = 1;
  const FitResult one = FitStack(stack, options, testing::TestChromophores());
  options.threads = 2;
  const FitResult two = FitStack(stack, options, testing::TestChromophores());
  EXPECT_EQ(one.chi2, two.chi2);
  for (std::size_t i = 0; i < 256; ++i)
    ASSERT_EQ(one.maps[Parameter::kC_hd].data()[i], two.maps[Parameter::kC_hd].data()[i]);
}

// What a caller got wrong is an InputError (exit code 2), before any table is built.
TEST(FitStack, BadInputIsAnInputError) {
  ReflectanceStack stack;
  stack.bands = {{500, 0}};
  stack.reflectance = {PlaneF(4, 4, 0.4f)};
  EXPECT_THROW(FitStack(stack, FitOptions{}, testing::TestChromophores()), InputError);  // no pixel size
  stack.pixel_size_mm = 0.1;
  FitOptions options;
  options.profiles = "no-such-profiles";
  EXPECT_THROW(FitStack(stack, options, testing::TestChromophores()), InputError);
  options = {};
  options.tissue.epidermis_thickness_mm = -1.0;
  EXPECT_THROW(FitStack(stack, options, testing::TestChromophores()), InputError);
}

}  // namespace
}  // namespace dermap
