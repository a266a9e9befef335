// SPDX-License-Identifier: Apache-2.0
// Figures of the report against arithmetic by hand.
#include "fit/report_statistics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "tests/fit/report/sample_fit.h"

namespace dermap {
namespace {

// Ranks of 0 ... 100 by hand.
TEST(ReportStatistics, QuantilesAreByRank) {
  std::vector<float> values(101);
  std::iota(values.begin(), values.end(), 0.0f);
  values.push_back(NAN);
  EXPECT_EQ(QuantileOf(values, 0.0), 0.0);
  EXPECT_EQ(QuantileOf(values, 0.5), 50.0);
  EXPECT_EQ(QuantileOf(values, 0.9), 90.0);
  EXPECT_TRUE(std::isnan(QuantileOf(std::vector<float>{NAN}, 0.5)));
}

// Ten pixels with errors of 1 % to 10 %, sigma 5.5 %: median of rank 5 of 0..9 is 6 %, the 90th percentile
// (rank 8) 9 %; five of ten lie within one sigma, all within two.
TEST(ReportStatistics, TruthErrorByHand) {
  PlaneF value(10, 1), sigma(10, 1, 0.055f);
  for (int i = 0; i < 10; ++i) value(i, 0) = 1.0f + 0.01f * static_cast<float>(i + 1);
  const ReportedMap map{"m", "", "", true, &value, &sigma, PlaneF(10, 1, 1.0f)};
  const TruthError error = CompareToTruth(map, {});
  EXPECT_NEAR(error.median_relative, 0.06, 1e-6);
  EXPECT_NEAR(error.percentile_90_relative, 0.09, 1e-6);
  EXPECT_NEAR(error.bias_relative, 0.06, 1e-6);
  EXPECT_NEAR(error.share_within_1_sigma, 0.5, 1e-9);
  EXPECT_NEAR(error.share_within_2_sigma, 1.0, 1e-9);
  EXPECT_EQ(error.pixels, 10);
}

// The header's contract: masked pixels and pixels without a value take no part; a true 0 has no relative
// error.
TEST(ReportStatistics, TruthErrorLeavesOutWhatItMust) {
  PlaneF value(4, 1, 1.1f), truth(4, 1, 1.0f);
  value(0, 0) = 99.0f;
  value(1, 0) = NAN;
  truth(2, 0) = 0.0f;
  Plane<std::uint32_t> flags(4, 1);
  flags(0, 0) = kFlagSaturated;
  const TruthError error = CompareToTruth({"m", "", "", true, &value, nullptr, truth}, flags);
  EXPECT_EQ(error.pixels, 2);
  EXPECT_NEAR(error.percentile_90_relative, 0.1, 1e-6);
  EXPECT_TRUE(std::isnan(error.share_within_1_sigma));
}

// By hand: the pixel without a measurement, and the masked one, take no part.
TEST(ReportStatistics, MeansAreOverTheMeasuredPixels) {
  PlaneF predicted(3, 1, 1.0f), measured(3, 1, 1.0f);
  predicted(2, 0) = 10.0f;
  measured(2, 0) = NAN;
  EXPECT_EQ(MeanOf(predicted), 4.0);
  EXPECT_EQ(MeanOf(WhereFinite(predicted, measured)), 1.0);
  Plane<std::uint32_t> flags(3, 1);
  flags(2, 0) = kFlagSaturated | kFlagAtBound;
  flags(1, 0) = kFlagAtBound;
  EXPECT_EQ(MeanOf(WithoutMasked(predicted, flags)), 1.0);
  EXPECT_EQ(MeanOf(WithoutMasked(predicted, {})), 4.0);
}

// The sample's freckle of most melanin is centred at (0.62, 0.45) of the patch (sample_fit.cpp).
TEST(ReportStatistics, PointsAreWhereTheirNamesSay) {
  const SampleFit sample = MakeSampleFit(80, 80);
  const auto points = NamedPoints(sample.fit);
  ASSERT_EQ(points.size(), 4u);
  EXPECT_EQ(points[1].name, "most melanin");
  EXPECT_NEAR(points[1].x, 0.62 * 80, 4.0);
  EXPECT_NEAR(points[1].y, 0.45 * 80, 4.0);
  EXPECT_EQ(points[0].letter, 'A');
}

// Mean of 2 x 2 copies of a map is the map: the truth comes at twice the size of the fit.
TEST(ReportStatistics, TruthIsBroughtToTheSizeOfTheFit) {
  SampleFit sample = MakeSampleFit(6, 4);
  PlaneF& truth = sample.truth.maps[Parameter::kC_m];
  for (int y = 0; y < truth.height(); ++y) {
    for (int x = 0; x < truth.width(); ++x)
      truth(x, y) = static_cast<float>(x / 2 + 10 * (y / 2)) + (x % 2 ? 0.5f : -0.5f);
  }
  const auto maps = ReportedMaps(sample.fit, &sample.truth);
  ASSERT_EQ(maps.size(), 5u);
  ASSERT_TRUE(maps[0].truth.has_value());
  for (int y = 0; y < 4; ++y) {
    for (int x = 0; x < 6; ++x) EXPECT_NEAR((*maps[0].truth)(x, y), x + 10 * y, 1e-5);
  }
  EXPECT_FALSE(maps[3].free) << "C_bc";
  EXPECT_TRUE(maps[4].free) << "C_hd";
}

}  // namespace
}  // namespace dermap
