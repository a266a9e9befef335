// SPDX-License-Identifier: Apache-2.0
// Names of methods, metrics, starts and free parameters.
#include "fit/options.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <string>

#include "common/core/error.h"

namespace dermap {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::string MessageOf(const std::function<void()>& call) {
  try {
    call();
  } catch (const InputError& error) {
    return error.what();
  }
  return "no InputError";
}

// The command line's words, docs/formats.md.
TEST(FitOptions, NamesRoundTrip) {
  for (const char* name : {"fast", "descent", "ceres"}) EXPECT_EQ(NameOf(FitMethodFromName(name)), name);
  for (const char* name : {"curvature", "plain"}) EXPECT_EQ(NameOf(DescentMetricFromName(name)), name);
  for (const char* name : {"average", "local", "random"}) EXPECT_EQ(NameOf(StartPointFromName(name)), name);
}

// A method that is not built in is named together with those that are.
TEST(FitOptions, UnknownMethodNamesTheKnownOnes) {
  EXPECT_THAT(MessageOf([] { FitMethodFromName("newton"); }),
              AllOf(HasSubstr("'newton'"), HasSubstr("fast, descent")));
}

// [D08 table 1]'s names; the result is in table 1's order whatever the order asked for.
TEST(FitOptions, FreeParametersParse) {
  EXPECT_TRUE(FreeParametersFromText("auto").empty());
  EXPECT_THAT(FreeParametersFromText("C_hd,C_m"), ElementsAre(Parameter::kC_m, Parameter::kC_hd));
}

// Rubbish is named, never skipped.
TEST(FitOptions, BadFreeParametersAreNamed) {
  EXPECT_THAT(MessageOf([] { FreeParametersFromText("C_m,C_x"); }),
              AllOf(HasSubstr("'C_x'"), HasSubstr("beta_m")));
  EXPECT_THAT(MessageOf([] { FreeParametersFromText("C_m,C_m"); }), HasSubstr("twice"));
  EXPECT_THAT(MessageOf([] { FreeParametersFromText(""); }), HasSubstr("Unknown free parameter ''"));
  EXPECT_THAT(MessageOf([] { FreeParametersFromText("C_m,"); }), HasSubstr("Unknown free parameter ''"));
}

}  // namespace
}  // namespace dermap
