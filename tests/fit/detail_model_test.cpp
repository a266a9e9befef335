// SPDX-License-Identifier: Apache-2.0
// Where skin is active and where it is quiet, from details of known variance.
#include "fit/detail_model.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace dermap {
namespace {

constexpr int kFine = 32, kCoarse = 16;
constexpr auto kMelanin = static_cast<std::size_t>(Pigment::kMelanin);

// One free parameter's details of an octave: of variance `left` and `right` in the two halves, of the prior's
// unit, and determined by `told`.
DetailStatistics Details(int size, double left, double right, double told, std::uint32_t seed) {
  std::mt19937 generator(seed);
  std::normal_distribution<double> normal;
  DetailStatistics statistics;
  statistics.pixels = size * size;
  statistics.energy[kMelanin] = statistics.told[kMelanin] = PlaneF(size, size);
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < size; ++x) {
      const double square = told * (x < size / 2 ? left : right) * std::pow(normal(generator), 2);
      statistics.energy[kMelanin](x, y) = static_cast<float>(square);
      statistics.told[kMelanin](x, y) = static_cast<float>(told);
      statistics.squares[0] += square;
      statistics.determined[0] += told;
    }
  return statistics;
}

double MeanOf(const PlaneF& plane, int from, int to) {
  double sum = 0.0;
  for (int y = 0; y < plane.height(); ++y)
    for (int x = from; x < to; ++x) sum += plane(x, y) / (plane.height() * (to - from));
  return sum;
}

struct Found {
  double left, right;
};

// At the finest of three octaves.
Found ActivityFrom(const DetailStatistics& fine, const DetailStatistics& coarse) {
  DetailModel model = FirstDetailModel(3, {});
  const DetailStatistics statistics[] = {fine, coarse, Details(1, 1.0, 1.0, 1.0, 3)};
  Update(statistics, 1, ViewFrom(model, 0));
  const PlaneF* activity =
      ViewFrom(model, 0).ActivityOf(0, {kFine, kFine}, Parameter::kBeta_m);  // melanin's kind goes with it
  if (!activity) return {0.0, 0.0};
  return {MeanOf(*activity, 2, kFine / 2 - 2), MeanOf(*activity, kFine / 2 + 2, kFine - 2)};
}

// Source: the variances that the details were drawn with; nine pixels of them against four of a guess at 1:
// (9 v + 4) / 13.
TEST(Activity, IsTheDetailsOwnWhereTheyAreTold) {
  const Found found = ActivityFrom(Details(kFine, 4.0, 0.25, 1.0, 1), Details(kCoarse, 1.0, 1.0, 0.0, 2));
  EXPECT_NEAR(found.left, (9.0 * 4.0 + 4.0) / 13.0, 0.35);
  EXPECT_NEAR(found.right, (9.0 * 0.25 + 4.0) / 13.0, 0.05);
}

TEST(Activity, IsTheCoarserOctavesWhereTheyAreNot) {
  const Found found = ActivityFrom(Details(kFine, 1.0, 1.0, 0.0, 1), Details(kCoarse, 4.0, 0.25, 1.0, 2));
  EXPECT_NEAR(found.left, (9.0 * 4.0 + 4.0) / 13.0, 0.7);
  EXPECT_NEAR(found.right, (9.0 * 0.25 + 4.0) / 13.0, 0.1);
}

TEST(Activity, OfOnePigmentSaysNothingOfAnother) {
  DetailModel model = FirstDetailModel(3, {});
  const DetailStatistics statistics[] = {Details(kFine, 4.0, 0.25, 1.0, 1),
                                         Details(kCoarse, 1.0, 1.0, 1.0, 2), Details(1, 1.0, 1.0, 1.0, 3)};
  Update(statistics, 1, ViewFrom(model, 0));
  EXPECT_EQ(ViewFrom(model, 0).ActivityOf(0, {kFine, kFine}, Parameter::kC_hd), nullptr);
}

}  // namespace
}  // namespace dermap
