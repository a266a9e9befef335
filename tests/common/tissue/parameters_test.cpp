// SPDX-License-Identifier: Apache-2.0
// The table of parameters and the maps that hold them.
#include "common/tissue/parameters.h"

#include <gtest/gtest.h>

namespace dermap {
namespace {

// [D08 table 1]: names in its order, and the typical range of each.
TEST(Parameters, HaveTheBoundsOfTable1) {
  const struct {
    const char* name;
    double lower, upper;
  } expected[] = {
      {"C_m", 0.0, 0.5}, {"beta_m", 0.0, 1.0}, {"C_he", 0.0, 0.05}, {"C_bc", 0.0, 0.05}, {"C_hd", 0.0, 0.1}};
  for (int i = 0; i < kParameterCount; ++i) {
    EXPECT_EQ(kParameters[i].name, expected[i].name);
    EXPECT_EQ(kParameters[i].lower, expected[i].lower);
    EXPECT_EQ(kParameters[i].upper, expected[i].upper);
    EXPECT_EQ(ParameterFromName(expected[i].name), static_cast<Parameter>(i));
  }
  EXPECT_EQ(ParameterFromName("rho_s"), std::nullopt);
  EXPECT_EQ(ParameterFromName(""), std::nullopt);
}

// A prior mean outside of its own bounds could never be reached.
TEST(Parameters, AverageSkinLiesWithinItsBounds) {
  const auto mean = AverageSkin();
  for (int i = 0; i < kParameterCount; ++i) {
    EXPECT_GT(mean[i], kParameters[i].lower) << kParameters[i].name;
    EXPECT_LT(mean[i], kParameters[i].upper) << kParameters[i].name;
  }
}

// The value given for each parameter, at every pixel.
TEST(ParameterMaps, AreUniformWhenMadeFromOneVector) {
  const ParameterMaps maps(3, 2, {0.1, 0.2, 0.03, 0.04, 0.05});
  EXPECT_EQ(maps.width(), 3);
  EXPECT_EQ(maps.height(), 2);
  EXPECT_TRUE(maps.junction_absorbance.empty());
  EXPECT_EQ(maps[Parameter::kBeta_m](2, 1), 0.2f);
  EXPECT_EQ(maps[Parameter::kC_hd](0, 0), 0.05f);
}

}  // namespace
}  // namespace dermap
