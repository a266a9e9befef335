// SPDX-License-Identifier: Apache-2.0
// How much of absorption's detail is seen through skin.
#include "fit/blur_share.h"

#include <gtest/gtest.h>

#include "tests/fit/scene.h"

namespace dermap {
namespace {

class BlurShareTest : public ::testing::Test {
 protected:
  static BlurTable Measure(double pixel_size_mm, int octaves) {
    ParameterVector light = AverageSkin(), dark = AverageSkin();
    light[0] = 0.02;
    dark[0] = 0.3;
    const ParameterVector skins[] = {light, dark};
    return MeasureBlur(testing::MakeModel(testing::FourBands(), testing::Window(pixel_size_mm)), skins,
                       octaves);
  }
};

// Detail is seen better the coarser it is, the shallower it lies and the darker the skin, which lets light go
// less far.
TEST_F(BlurShareTest, GrowsWithSizeAndAbsorptionAndFallsWithDepth) {
  const BlurTable table = Measure(0.06, 5);
  for (int band = 0; band < 4; ++band) {
    for (int octave = 0; octave < 5; ++octave) {
      const BlurShare light = table[octave][band].At(0.01), dark = table[octave][band].At(1e3);
      EXPECT_LT(light.dermis, light.epidermis);
      EXPECT_LT(light.epidermis, dark.epidermis + 1e-3f);
      if (octave > 0) {
        EXPECT_GT(light.epidermis, table[octave - 1][band].At(0.01).epidermis);
        EXPECT_GE(light.dermis, table[octave - 1][band].At(0.01).dermis);
      }
    }
  }
}

// Pixels far larger than light goes see all of it.
TEST_F(BlurShareTest, NothingIsLostInVeryLargePixels) {
  const BlurTable table = Measure(20.0, 1);
  for (const BlurCurve& band : table[0]) {
    EXPECT_FLOAT_EQ(band.At(1.0).epidermis, 1.0f);
    EXPECT_FLOAT_EQ(band.At(1.0).dermis, 1.0f);
  }
}

TEST(BlurCurve, IsLinearInTheLogarithmAndConstantBeyond) {
  BlurCurve curve;
  EXPECT_FLOAT_EQ(curve.At(1.0).epidermis, 1.0f);
  curve.Add(1.0, {0.2f, 0.1f, 0.1f});
  curve.Add(100.0, {0.6f, 0.3f, 0.3f});
  EXPECT_NEAR(curve.At(10.0).epidermis, 0.4f, 1e-6);
  EXPECT_FLOAT_EQ(curve.At(0.1).dermis, 0.1f);
  EXPECT_FLOAT_EQ(curve.At(1e4).dermis, 0.3f);
}

}  // namespace
}  // namespace dermap
