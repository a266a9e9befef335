// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "common/files/stack.h"

namespace dermap {
namespace {

// Fichet, Pacanowski, Wilkie, JCGT 2021, section 4: "T.", the number with a comma, the unit.
TEST(SpectralNames, WriteTheLayoutsForm) {
  EXPECT_EQ(SpectralChannelName("T", 450.0), "T.450,000000nm");
  EXPECT_EQ(SpectralChannelName("sigma", 632.8), "sigma.632,800000nm");
}

// What was written is read as the very same number.
TEST(SpectralNames, ComeBackExactly) {
  for (double nm = 350.0; nm <= 1000.0; nm += 0.125) {
    ASSERT_EQ(WavelengthOfChannel(SpectralChannelName("T", nm), "T"), nm);
  }
}

// The layout's SI prefixes and its two units; 2.99792458e8 m/s is the speed of light (SI).
TEST(SpectralNames, ReadEveryUnitOfTheLayout) {
  for (const char* name : {"T.450nm", "T.450,0nm", "T.,45um", "T.0,45um", "T.4,5e-7m", "T.4.5E-07m",
                           "T.450000pm", "T.0,00045mm", "T.4,5e2nm", "T.450.000000nm", "T.666,20546222THz"}) {
    const auto nm = WavelengthOfChannel(name, "T");
    ASSERT_TRUE(nm) << name;
    EXPECT_NEAR(*nm, 450.0, 1e-6) << name;
  }
}

// Names of other things.
TEST(SpectralNames, AreNulloptWhereTheNameIsNoSuchChannel) {
  for (const char* name :
       {"T", "T.", "T.nm", "T.450", "T.450n", "T.450xm", "T.-450nm", "T.450,0,0nm", "T.450nm.500nm", "T.0nm",
        "T.450nm ", "T 450nm", "S0.450nm", "sigma.450nm", "t.450nm", "T.infnm", "T.1e999nm", "T.0x1p4nm"}) {
    EXPECT_FALSE(WavelengthOfChannel(name, "T")) << name;
  }
  EXPECT_EQ(WavelengthOfChannel("sigma.450nm", "sigma"), 450.0);
}

}  // namespace
}  // namespace dermap
