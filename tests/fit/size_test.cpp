// SPDX-License-Identifier: Apache-2.0
// The automatic size.
#include "fit/size.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace dermap {
namespace {

using ::testing::HasSubstr;

// By hand: 100 renders of 1e-5 s a pixel are 65.5 s at 256^2, 16.4 s at 128^2.
TEST(LargestAffordableSize, FollowsTheBudget) {
  std::vector<std::string> decisions;
  EXPECT_EQ(LargestAffordableSize(256, 1.0, 1e-5, 100, 66, decisions), 256);
  EXPECT_THAT(decisions.back(), HasSubstr("full size"));
  EXPECT_EQ(LargestAffordableSize(256, 1.0, 1e-5, 100, 65, decisions), 128);
  EXPECT_THAT(decisions.back(), HasSubstr("128 pixels along the longer side instead of the stack's 256"));
  EXPECT_EQ(LargestAffordableSize(256, 0.5, 1e-5, 100, 33, decisions), 256);
  EXPECT_EQ(LargestAffordableSize(500, 1.0, 1e-5, 100, 66, decisions), 256);
}

// A budget that nothing fits still gets the smallest size, never none.
TEST(LargestAffordableSize, HasASmallest) {
  std::vector<std::string> decisions;
  EXPECT_EQ(LargestAffordableSize(256, 1.0, 1.0, 1e6, 1e-3, decisions), 32);
  EXPECT_EQ(LargestAffordableSize(20, 1.0, 1.0, 1e6, 1e-3, decisions), 20);
}

}  // namespace
}  // namespace dermap
