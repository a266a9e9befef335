// SPDX-License-Identifier: Apache-2.0
// One picture in two bands.
#include "fit/copied_bands.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "fit/fit.h"
#include "tests/fit/scene.h"

namespace dermap {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

class CopiedBands : public ::testing::Test {
 protected:
  std::vector<std::string> Said() {
    data_ = testing::Prepared(stack_, 3);
    std::vector<std::string> said;
    PrepareStack(stack_, {}, 3, said);
    return said;
  }
  bool IsOut(int band) const { return !data_.Has(band, 100); }

  ParameterMaps truth_ = testing::SpottedSkin(32, 0.05);
  ReflectanceStack stack_ = testing::NoisyStack(
      testing::MakeModel(testing::EightBands(), testing::Window(7.5 / 32)), truth_, 0.005, 4);
  FitData data_;
};

TEST_F(CopiedBands, AStackWithoutACopyKeepsItsBands) {
  for (const std::string& sentence : Said()) EXPECT_THAT(sentence, Not(HasSubstr("picture")));
  for (int b = 0; b < 8; ++b) EXPECT_FALSE(IsOut(b)) << b;
}

// The file of band 3 in band 4's place, calibrated by another Spectralon frame's mean: the fit goes on
// without either and finds the skin.
TEST_F(CopiedBands, OfTwoWavelengthsBothAreLeftOut) {
  stack_.reflectance[4] = stack_.reflectance[3];
  for (float& value : stack_.reflectance[4].values()) value *= 1.07f;
  const FitResult fit = FitStack(stack_, {}, testing::TestChromophores());
  EXPECT_THAT(fit.decisions, Contains(HasSubstr("hold the same picture")));
  EXPECT_TRUE(std::isnan(fit.measured[3](5, 5)) && std::isnan(fit.measured[4](5, 5)));
  EXPECT_LT(testing::MedianRelativeError(fit.maps[Parameter::kC_m], truth_[Parameter::kC_m]), 0.03);
  EXPECT_LT(fit.chi2, 1.3);
}

TEST_F(CopiedBands, OfOneWavelengthTheFirstStays) {
  stack_.bands.insert(stack_.bands.begin() + 3, stack_.bands[3]);
  stack_.reflectance.insert(stack_.reflectance.begin() + 3, stack_.reflectance[3]);
  stack_.sigma.insert(stack_.sigma.begin() + 3, stack_.sigma[3]);
  EXPECT_THAT(Said(), Contains(HasSubstr("twice with the same picture")));
  EXPECT_FALSE(IsOut(3));
  EXPECT_TRUE(IsOut(4));
}

// Without noise and without detail all bands are alike but for a factor: that is no sign of a copy.
TEST_F(CopiedBands, EvenSkinIsNoCopy) {
  for (PlaneF& plane : stack_.reflectance)
    for (float& value : plane.values()) value = plane(0, 0);
  Said();
  for (int b = 0; b < 8; ++b) EXPECT_FALSE(IsOut(b)) << b;
}

}  // namespace
}  // namespace dermap
