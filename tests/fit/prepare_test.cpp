// SPDX-License-Identifier: Apache-2.0
// Checks and masks of stacks.
#include "fit/prepare.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "common/core/error.h"
#include "fit/fit_result.h"

namespace dermap {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

ReflectanceStack GrayStack(int bands, float value = 0.4f) {
  ReflectanceStack stack;
  for (int b = 0; b < bands; ++b) stack.bands.push_back({450.0 + 20.0 * b, 10.0});
  stack.reflectance.assign(bands, PlaneF(3, 2, value));
  stack.sigma.assign(bands, PlaneF(3, 2, 0.01f));
  stack.pixel_size_mm = 0.1;
  return stack;
}

std::string MessageOf(const std::function<void()>& call) {
  try {
    call();
  } catch (const InputError& error) {
    return error.what();
  }
  return "no InputError";
}

struct Result {
  FitData data;
  std::vector<std::string> decisions;
};
Result Prepare(const ReflectanceStack& stack, int free_count = 1, const FitOptions& options = {}) {
  Result result;
  result.data = PrepareStack(stack, options, free_count, result.decisions);
  return result;
}

// The remedy that a researcher with a foreign stack needs.
TEST(PrepareStack, MissingPixelSizeNamesTheOption) {
  ReflectanceStack stack = GrayStack(3);
  stack.pixel_size_mm.reset();
  EXPECT_THAT(MessageOf([&] { Prepare(stack); }),
              AllOf(HasSubstr("dermap:pixelSizeMm"), HasSubstr("--pixel-size-mm")));
  FitOptions options;
  options.pixel_size_mm = 0.25;
  EXPECT_EQ(Prepare(stack, 1, options).data.conditions.pixel_size_mm, 0.25);
  stack.pixel_size_mm = -1.0;
  EXPECT_THAT(MessageOf([&] { Prepare(stack); }), HasSubstr("must be above 0"));
}

// A stack without one number cannot be fitted; one number is enough for one parameter.
// docs/formats.md: what is asked for, else the stack's own, else a thousandth, of which error bars then allow
// for twice as much.
TEST(PrepareStack, SharedErrorIsAskedForOrTheStacksOrTheDefault) {
  ReflectanceStack stack = GrayStack(8);
  FitOptions options;
  std::vector<std::string> decisions;
  const FitData unstated = PrepareStack(stack, options, 5, decisions);
  EXPECT_EQ(unstated.shared_error, kSharedError);
  EXPECT_EQ(unstated.shared_error_allowance, kUnstatedAllowance);
  EXPECT_THAT(decisions, testing::Not(Contains(HasSubstr("as the stack says"))));
  stack.shared_error = 0.0;
  const FitData stated = PrepareStack(stack, options, 5, decisions);
  EXPECT_EQ(stated.shared_error, 0.0);
  EXPECT_EQ(stated.shared_error_allowance, 1.0);
  EXPECT_THAT(decisions, Contains(HasSubstr("as the stack says")));
  options.shared_error = 0.02;
  const FitData asked = PrepareStack(stack, options, 5, decisions);
  EXPECT_EQ(asked.shared_error, 0.02);
  EXPECT_EQ(asked.shared_error_allowance, 1.0);
}

TEST(PrepareStack, AllMissingIsAnError) {
  ReflectanceStack stack = GrayStack(2, kNaN);
  EXPECT_THAT(MessageOf([&] { Prepare(stack); }), HasSubstr("no usable datum"));
  stack.reflectance[1](2, 1) = 0.3f;
  const FitData data = Prepare(stack).data;
  EXPECT_EQ(data.fitted(2, 1), 1);
  EXPECT_EQ(data.fitted(0, 0), 0);
  EXPECT_TRUE(data.flags(0, 0) & kFlagSaturated);
}

// Each kind of value that is no reflectance is left out, counted in a sentence, and takes only its own band
// with it.
TEST(PrepareStack, ImpossibleValuesAreMaskedAndCounted) {
  ReflectanceStack stack = GrayStack(3);
  stack.reflectance[0](0, 0) = kNaN;
  stack.reflectance[1](1, 0) = 1.6f;
  stack.reflectance[2](2, 0) = -0.2f;
  const Result result = Prepare(stack, 2);
  EXPECT_FALSE(result.data.Has(0, 0));
  EXPECT_TRUE(result.data.Has(1, 0));
  EXPECT_FALSE(result.data.Has(1, 1));
  EXPECT_FALSE(result.data.Has(2, 2));
  EXPECT_TRUE(result.data.flags(1, 0) & kFlagOutsideValidity);
  EXPECT_TRUE(result.data.flags(2, 0) & kFlagOutsideValidity);
  EXPECT_EQ(result.data.flags(0, 0), 0u);
  EXPECT_EQ(result.data.fitted(0, 0), 1);  // two of three bands are enough for two parameters
  EXPECT_THAT(result.decisions, Contains(HasSubstr("1 of 18 data are missing")));
  EXPECT_THAT(result.decisions, Contains(HasSubstr("1 of 18 data are above")));
  EXPECT_THAT(result.decisions, Contains(HasSubstr("1 of 18 data are negative")));
}

// Noise of 0.01 around a dark 0.005 is below 0 every third time: leaving it out would bias the mean upwards.
TEST(PrepareStack, NegativeNoiseAroundDarkSkinIsKept) {
  ReflectanceStack stack = GrayStack(1);
  stack.reflectance[0](0, 0) = -0.02f;
  EXPECT_TRUE(Prepare(stack).data.Has(0, 0));
}

// Documented default: 1 % of the reflectance plus 0.001.
TEST(PrepareStack, DefaultNoiseIsRecorded) {
  ReflectanceStack stack = GrayStack(1, 0.5f);
  stack.sigma.clear();
  const Result result = Prepare(stack);
  EXPECT_NEAR(result.data.sigma[0](1, 1), 0.006, 1e-7);
  EXPECT_THAT(result.decisions, Contains(HasSubstr("states no noise")));
  stack = GrayStack(1, 0.5f);
  EXPECT_THAT(Prepare(stack).decisions, IsEmpty());
  stack.sigma[0](0, 0) = 0.0f;
  stack.sigma[0](1, 0) = kNaN;
  const Result partly = Prepare(stack);
  EXPECT_NEAR(partly.data.sigma[0](1, 0), 0.006, 1e-7);
  EXPECT_THAT(partly.decisions, Contains(HasSubstr("2 of 6 data have no usable sigma")));
}

// The stack's own mask.
TEST(PrepareStack, InvalidPixelsAreMasked) {
  ReflectanceStack stack = GrayStack(2);
  stack.valid = PlaneF(3, 2, 1.0f);
  stack.valid(1, 1) = 0.0f;
  const FitData data = Prepare(stack).data;
  EXPECT_FALSE(data.Has(0, 4));
  EXPECT_EQ(data.fitted(1, 1), 0);
  EXPECT_TRUE(std::isnan(data.measured[1](1, 1)));
}

// A stack whose planes differ is refused before anything reads beyond one.
TEST(PrepareStack, PlanesOfDifferentShapesAreAnError) {
  ReflectanceStack stack = GrayStack(2);
  stack.reflectance[1] = PlaneF(2, 2, 0.4f);
  EXPECT_THAT(MessageOf([&] { Prepare(stack); }), HasSubstr("differ in shape"));
}

// The documented order: C_bc, C_he, beta_m, C_hd go first; one band tells melanin alone.
TEST(ChooseFreeParameters, NeverMoreThanBands) {
  std::vector<std::string> decisions;
  EXPECT_EQ(ChooseFreeParameters({}, 8, decisions).size(), 5u);
  EXPECT_THAT(ChooseFreeParameters({}, 3, decisions),
              ElementsAre(Parameter::kC_m, Parameter::kBeta_m, Parameter::kC_hd));
  EXPECT_THAT(ChooseFreeParameters({}, 1, decisions), ElementsAre(Parameter::kC_m));
  EXPECT_THAT(decisions.back(), AllOf(HasSubstr("Only C_m is free"), HasSubstr("C_bc, C_he, beta_m, C_hd")));
  EXPECT_THAT(MessageOf([&] {
                ChooseFreeParameters({Parameter::kC_m, Parameter::kC_hd}, 1, decisions);
              }),
              AllOf(HasSubstr("1 band"), HasSubstr("C_m, C_hd"), HasSubstr("--free auto")));
}

}  // namespace
}  // namespace dermap
