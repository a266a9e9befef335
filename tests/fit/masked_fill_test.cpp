// SPDX-License-Identifier: Apache-2.0
// Filling of masked pixels.
#include "fit/masked_fill.h"

#include <gtest/gtest.h>

namespace dermap {
namespace {

// The mean of the eight neighbours, by hand.
TEST(MaskedFill, ASinglePixelIsItsNeighboursMean) {
  Plane<std::uint8_t> known(3, 3, 1);
  known(1, 1) = 0;
  ParameterMaps maps(3, 3, AverageSkin());
  for (int i = 0; i < 9; ++i) maps[Parameter::kC_m].data()[i] = static_cast<float>(i);
  maps[Parameter::kC_m](1, 1) = 99.0f;
  MaskedFill(known).Apply(maps);
  EXPECT_FLOAT_EQ(maps[Parameter::kC_m](1, 1), (0 + 1 + 2 + 3 + 5 + 6 + 7 + 8) / 8.0f);
}

// With one known pixel everything becomes it, however far; known pixels are never changed.
TEST(MaskedFill, ReachesEveryPixelRingByRing) {
  Plane<std::uint8_t> known(9, 5, 0);
  known(8, 0) = 1;
  ParameterMaps maps(9, 5, AverageSkin());
  maps[Parameter::kC_hd](8, 0) = 0.07f;
  MaskedFill(known).Apply(maps);
  for (float value : maps[Parameter::kC_hd].values()) EXPECT_FLOAT_EQ(value, 0.07f);
}

// Nothing masked, nothing touched.
TEST(MaskedFill, LeavesKnownPixelsAlone) {
  ParameterMaps maps(2, 2, AverageSkin());
  maps[Parameter::kC_m](1, 0) = 0.3f;
  MaskedFill(Plane<std::uint8_t>(2, 2, 1)).Apply(maps);
  EXPECT_FLOAT_EQ(maps[Parameter::kC_m](1, 0), 0.3f);
  EXPECT_FLOAT_EQ(maps[Parameter::kC_m](0, 0), 0.06f);
}

}  // namespace
}  // namespace dermap
