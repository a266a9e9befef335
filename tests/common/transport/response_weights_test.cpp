// SPDX-License-Identifier: Apache-2.0
// Planes of weights against the tables' own interpolation.
#include "common/transport/response_weights.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/common/transport/scenes.h"

namespace dermap {
namespace {

PlaneF Absorption(int width, int height) {
  PlaneF mu_a = Noise(width, height, 7, std::log(0.02f), std::log(30.0f));
  for (float& value : mu_a.values()) value = std::exp(value);
  return mu_a;
}

// ProfileTable::Weights, one pixel at a time, where the patch lies, and its edge's values around it.
TEST(ResponseWeights, AreTheTablesWeightsInEveryPixel) {
  const ProfileTable& table = TestTables(560).r2_diffuse;
  const PlaneF mu_a = Absorption(21, 17);
  const Domain domain = MakeDomain(21, 17, 4.0);
  TablePositions positions;
  positions.Set(mu_a, domain);
  ResponseWeights weights;
  weights.Set(table, positions, domain.Whole());
  GaussianWeights expected;
  for (int y = 0; y < domain.height; ++y) {
    for (int x = 0; x < domain.width; ++x) {
      const int px = std::clamp(x - domain.patch.x, 0, 20), py = std::clamp(y - domain.patch.y, 0, 16);
      table.Weights(mu_a(px, py), expected);
      for (int i = 0; i < kGaussianCount; ++i) {
        const float found = weights.active(i) ? weights.plane(i)(x, y) : 0.0f;
        ASSERT_NEAR(found, expected[i], 1e-6) << "Gaussian " << i << " at " << x << ", " << y;
      }
    }
  }
}

// The same weights, cut out: a region is a window onto the whole.
TEST(ResponseWeights, OfARegionAreThoseOfTheWholeThere) {
  const ProfileTable& table = TestTables(560).t1_backward;
  const Domain domain = MakeDomain(30, 26, 6.0);
  TablePositions positions;
  positions.Set(Absorption(30, 26), domain);
  ResponseWeights whole, patch;
  whole.Set(table, positions, domain.Whole());
  patch.Set(table, positions, domain.patch);
  for (int i = 0; i < kGaussianCount; ++i) {
    ASSERT_EQ(whole.active(i), patch.active(i));
    if (!whole.active(i)) continue;
    for (int y = 0; y < 26; ++y) {
      for (int x = 0; x < 30; ++x) {
        ASSERT_EQ(patch.plane(i)(x, y), whole.plane(i)(x + domain.patch.x, y + domain.patch.y));
      }
    }
  }
}

// Under the tape another table rules: inside as the one, outside as the other.
TEST(ResponseWeights, OfTwoTablesChangeAtThePatch) {
  const BandTables& tables = TestTables(560);
  const Domain domain = MakeDomain(20, 20, 5.0);
  TablePositions positions;
  positions.Set(Absorption(20, 20), domain);
  ResponseWeights free, black, both;
  free.Set(tables.r1_backward, positions, domain.Whole());
  black.Set(tables.r1_backward_black, positions, domain.Whole());
  both.SetTwo(tables.r1_backward, tables.r1_backward_black, positions, domain.Whole(), domain.patch);
  double apart = 0.0;
  for (int i = 0; i < kGaussianCount; ++i) {
    if (!both.active(i)) continue;
    for (int y = 0; y < domain.height; ++y) {
      for (int x = 0; x < domain.width; ++x) {
        const Region& p = domain.patch;
        const bool inside = x >= p.x && x < p.x + p.width && y >= p.y && y < p.y + p.height;
        const ResponseWeights& own = inside ? free : black;
        ASSERT_NEAR(both.plane(i)(x, y), own.active(i) ? own.plane(i)(x, y) : 0.0f, kNegligibleWeight)
            << i << ": " << x << ", " << y;
        if (free.active(i) && black.active(i)) apart += std::abs(free.plane(i)(x, y) - black.plane(i)(x, y));
      }
    }
  }
  EXPECT_GT(apart, 1.0);  // the two tables do differ
}

}  // namespace
}  // namespace dermap
