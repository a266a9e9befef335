// SPDX-License-Identifier: Apache-2.0
// Sums over path lengths against the transforms that they stand for.
#include "common/optics/path_kernels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "common/optics/profile_table.h"

namespace dermap {
namespace {

const BandTables& Tables(const std::string& source) {
  static const BandTables kExact = BuildBandTables(*MakeProfileSource("exact"), 560.0, {});
  static const BandTables kMultipole = BuildBandTables(*MakeProfileSource("multipole"), 560.0, {});
  return source == "exact" ? kExact : kMultipole;
}

// Source: the source's own transforms, at absorptions between the table's entries and all its frequencies.
// Where next to nothing of a transform is left, what is left is the source's own quadrature error.
TEST(TransformTable, IsTheSourceBetweenItsEntries) {
  const auto k = TableFrequencies_per_mm();
  for (const char* name : {"exact", "multipole"}) {
    const auto source = MakeProfileSource(name);
    const BandTables& tables = Tables(name);
    for (const double mu_a : {0.02, 0.11, 0.7, 2.3, 9.0, 37.0, 150.0}) {
      const auto upper = source->Epidermis(EpidermisOpticsOf({}, 560.0, mu_a), k);
      const auto lower = source->Dermis(DermisOpticsOf({}, 560.0, mu_a), k);
      const auto expect = [&](const ProfileTable& table, const std::vector<double>& transform,
                              const char* response) {
        const std::vector<double> found = table.transforms().At(mu_a);
        for (std::size_t i = 0; i < k.size(); ++i)
          EXPECT_NEAR(found[i], transform[i], std::max((k[i] > 100.0 ? 1e-2 : 3e-3) * transform[0], 2e-6))
              << name << ' ' << response << " mu_a " << mu_a << " k " << k[i];
      };
      expect(tables.r1_forward, upper.r_forward, "R1+");
      expect(tables.t1_forward, upper.t_forward, "T1+");
      expect(tables.r1_backward, upper.r_backward, "R1-");
      expect(tables.t1_backward, upper.t_backward, "T1-");
      expect(tables.r2_diffuse, lower.r_diffuse, "R2");
      expect(tables.r2_normal, lower.r_normal, "R2 normal");
    }
  }
}

// Source: the table, at absorptions that the reduction did not sample.
TEST(ScenePaths, ReducedToASceneStayWithinTheTolerance) {
  const BandTables& tables = Tables("exact");
  const TransformTable* const responses[] = {&tables.r1_forward.transforms(),
                                             &tables.t1_backward.transforms()};
  constexpr double kTolerance = 5e-4;
  for (const auto& [low, high] : {std::pair(0.5, 0.7), std::pair(0.3, 3.0), std::pair(1.0, 14.0)}) {
    const ScenePaths paths = ReducePaths(responses, low, high, kTolerance);
    EXPECT_LE(paths.error, kTolerance);
    for (double mu_a = low; mu_a <= high; mu_a *= 1.07) {
      for (std::size_t r = 0; r < 2; ++r) {
        const std::vector<double> expected = responses[r]->At(mu_a);
        const double total = std::max(expected[0], 1e-4);
        for (int k = 0; k < kGaussianFrequencies; k += 3) {
          double sum = 0.0;
          for (int j = 0; j < paths.count(); ++j)
            sum += paths.kernels[r][j][k] * std::exp(-mu_a * paths.lengths_mm[j]);
          EXPECT_NEAR(sum, expected[k], 2.0 * kTolerance * total) << low << ' ' << mu_a;
        }
      }
    }
  }
}

// A scene that varies less needs fewer path lengths.
TEST(ScenePaths, NarrowScenesNeedFewPathLengths) {
  const BandTables& tables = Tables("exact");
  const TransformTable* const responses[] = {&tables.r1_forward.transforms()};
  int last = 1;
  for (const double ratio : {1.5, 4.0, 30.0}) {
    const int count = ReducePaths(responses, 0.5, 0.5 * ratio, 2e-4).count();
    EXPECT_GT(count, last) << ratio;
    last = count;
  }
  EXPECT_LE(last, 9);
}

// Source: the header. Exactly as many lengths as asked for, and each more leaves clearly less error.
TEST(ScenePaths, TakeACountThatIsGiven) {
  const TransformTable* const responses[] = {&Tables("exact").r1_forward.transforms()};
  double last = 2.0;  // at 1, next to nothing is explained
  for (const int count : {1, 2, 3, 5}) {
    const ScenePaths paths = ReducePaths(responses, 0.5, 15.0, 1e-2, count);
    EXPECT_EQ(paths.count(), count);
    EXPECT_LT(paths.error, 0.8 * last) << count;
    last = paths.error;
  }
}

}  // namespace
}  // namespace dermap
