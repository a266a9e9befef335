// SPDX-License-Identifier: Apache-2.0
// Planes: layout and shape.
#include "common/core/image.h"

#include <gtest/gtest.h>

namespace dermap {
namespace {

// The layout that image.h promises: row by row from the top left, without padding, which file writers rely
// on.
TEST(Plane, LiesRowByRowWithoutPadding) {
  Plane<int> plane(3, 2);
  int value = 0;
  for (int y = 0; y < 2; ++y) {
    for (int x = 0; x < 3; ++x) plane(x, y) = value++;
  }
  for (int i = 0; i < 6; ++i) EXPECT_EQ(plane.data()[i], i);
  EXPECT_EQ(plane.Row(1), plane.data() + 3);
  EXPECT_EQ(plane.values().size(), 6u);
  EXPECT_EQ(&plane.values()[4], &plane(1, 1));
}

// By definition of a new plane.
TEST(Plane, IsFilledWithItsValueOrZero) {
  EXPECT_EQ(Plane<float>(2, 2)(1, 1), 0.0f);
  EXPECT_EQ(Plane<float>(2, 2, 1.5f)(0, 1), 1.5f);
}

// 4 x 2 and 2 x 4 have as many pixels but another shape.
TEST(Plane, ComparesShapesNotSizes) {
  const Plane<float> wide(4, 2);
  EXPECT_TRUE(wide.SameShape(Plane<int>(4, 2)));
  EXPECT_FALSE(wide.SameShape(Plane<float>(2, 4)));
  EXPECT_TRUE(wide.SameShape(4, 2));
  EXPECT_TRUE(PlaneF().empty());
  EXPECT_FALSE(wide.empty());
}

}  // namespace
}  // namespace dermap
