// SPDX-License-Identifier: Apache-2.0
// The front of time against error.
#include "studies/pareto.h"

#include <gtest/gtest.h>

namespace dermap {
namespace {

// Source: the definition; (2, 3) is slower and worse than (1, 2), (4, 1) is the most exact.
TEST(Pareto, FrontHoldsWhatNothingBeatsInBoth) {
  const std::vector<TimedError> points{{4, 1}, {2, 3}, {1, 2}, {0.5, 5}, {5, 1}, {0, 0.1}};
  EXPECT_EQ(ParetoFront(points), (std::vector<std::size_t>{3, 2, 0}));
}

// Source: the definition; times within 15 % and errors within their bar do not tell points apart.
TEST(Pareto, IsDominatedOnlyBeyondWhatCanBeTold) {
  EXPECT_TRUE(IsDominated({{2, 2}, {1, 1}}, 0));
  EXPECT_FALSE(IsDominated({{1.1, 2}, {1, 1}}, 0));
  EXPECT_FALSE(IsDominated({{2, 2, 1.5}, {1, 1}}, 0));
  EXPECT_FALSE(IsDominated({{2, 2}, {1, 1}}, 1));
}

}  // namespace
}  // namespace dermap
