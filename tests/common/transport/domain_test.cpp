// SPDX-License-Identifier: Apache-2.0
// The geometry around a patch.
#include "common/transport/domain.h"

#include <gtest/gtest.h>

namespace dermap {
namespace {

// What domain.h promises, over many shapes.
TEST(Domain, HoldsThePatchItsMarginAndItsHalvings) {
  for (const int width : {1, 16, 37, 256, 501}) {
    for (const int height : {1, 20, 256}) {
      for (const double margin : {0.0, 0.3, 9.0, 64.8}) {
        const Domain domain = MakeDomain(width, height, margin);
        EXPECT_EQ(domain.patch.width, width);
        EXPECT_EQ(domain.patch.height, height);
        EXPECT_GE(domain.patch.x, margin);
        EXPECT_GE(domain.patch.y, margin);
        EXPECT_GE(domain.width - width - domain.patch.x, margin);
        EXPECT_GE(domain.height - height - domain.patch.y, margin);
        EXPECT_EQ(domain.width % (1 << domain.levels), 0);
        EXPECT_EQ(domain.height % (1 << domain.levels), 0);
        EXPECT_LT(domain.width, width + 2 * (margin + 1) + (1 << domain.levels));
      }
    }
  }
}

// By hand: 2 x 1 values with one pixel around them.
TEST(Domain, RepeatsTheEdgeOrSurroundsItWithZeros) {
  PlaneF patch(2, 1);
  patch(0, 0) = 3.0f;
  patch(1, 0) = 5.0f;
  const Domain domain = MakeDomain(2, 1, 1.0);
  ASSERT_TRUE(domain.width == 4 && domain.height == 3);
  PlaneF replicated, zeros(4, 3, 9.0f);
  ReplicateOutwards(patch, domain, replicated);
  SurroundWithZeros(patch, domain, zeros);
  for (int y = 0; y < 3; ++y) {
    const float repeated[] = {3, 3, 5, 5}, surrounded[] = {0, 3, 5, 0};
    for (int x = 0; x < 4; ++x) {
      EXPECT_EQ(replicated(x, y), repeated[x]);
      EXPECT_EQ(zeros(x, y), y == 1 ? surrounded[x] : 0.0f);
    }
  }
}

}  // namespace
}  // namespace dermap
