// SPDX-License-Identifier: Apache-2.0
// Random fields and streams.
#include "acquire/simulated/random_field.h"

#include <gtest/gtest.h>

#include <cmath>

namespace dermap {
namespace {

// Mean 0, variance 1 and correlation exp(-d^2/2L^2), by definition. 400 fields, one pair of points each:
// standard error 5 %.
TEST(RandomField, HasItsVarianceAndCorrelation) {
  double sum = 0.0, sum2 = 0.0, product = 0.0;
  constexpr int kFields = 1600;
  for (int i = 0; i < kFields; ++i) {
    const RandomField field(RandomStream(5, "test", static_cast<std::uint64_t>(i)), 0.8);
    const double a = field.At(1.0, 2.0), b = field.At(1.0, 2.8);
    sum += a;
    sum2 += a * a;
    product += a * b;
  }
  EXPECT_NEAR(sum / kFields, 0.0, 4.0 / std::sqrt(kFields));
  EXPECT_NEAR(sum2 / kFields, 1.0, 4.0 * std::sqrt(2.0 / kFields));
  EXPECT_NEAR(product / kFields, std::exp(-0.5), 4.0 * std::sqrt((1.0 + std::exp(-1.0)) / kFields));
}

// Streams of one seed must not share their numbers, whatever the purpose and the index.
TEST(RandomStream, DependsOnSeedPurposeAndIndex) {
  EXPECT_EQ(RandomStream(1, "a", 2)(), RandomStream(1, "a", 2)());
  EXPECT_NE(RandomStream(1, "a", 2)(), RandomStream(2, "a", 2)());
  EXPECT_NE(RandomStream(1, "a", 2)(), RandomStream(1, "b", 2)());
  EXPECT_NE(RandomStream(1, "a", 2)(), RandomStream(1, "a", 3)());
}

}  // namespace
}  // namespace dermap
