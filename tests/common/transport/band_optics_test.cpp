// SPDX-License-Identifier: Apache-2.0
// Filters' nodes, totals without profiles, automatic terms.
#include "common/transport/band_optics.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/common/transport/scenes.h"

namespace dermap {
namespace {

// Abramowitz and Stegun, table 25.10, n = 5: nodes 0, 0.958572465, 2.020182870 and weights 0.945308720,
// 0.393619323, 0.019953242 for exp(-x^2), scaled to a Gaussian of variance 1 (sqrt 2, 1/sqrt pi).
TEST(FilterNodes, AreGaussHermites) {
  const std::vector<FilterNode> nodes = FilterNodes({560.0, 10.0});
  ASSERT_EQ(nodes.size(), 5u);
  const double sigma_nm = 10.0 / (2.0 * std::sqrt(2.0 * std::log(2.0)));
  const double x[] = {-2.020182870, -0.958572465, 0.0, 0.958572465, 2.020182870};
  const double w[] = {0.019953242, 0.393619323, 0.945308720, 0.393619323, 0.019953242};
  for (int i = 0; i < 5; ++i) {
    EXPECT_NEAR(nodes[i].wavelength_nm, 560.0 + std::sqrt(2.0) * sigma_nm * x[i], 1e-7);
    EXPECT_NEAR(nodes[i].weight, w[i] / std::sqrt(M_PI), 1e-8);
  }
}

// By definition: the weights sum to 1, the mean is the centre, and without a width there is one node.
TEST(FilterNodes, KeepTheCentreAndTheLight) {
  EXPECT_EQ(FilterNodes({500.0, 0.0}).size(), 1u);
  for (const double fwhm_nm : {2.0, 10.0, 40.0}) {
    const std::vector<FilterNode> nodes = FilterNodes({500.0, fwhm_nm});
    double weight = 0.0, mean = 0.0, variance = 0.0;
    for (const FilterNode& node : nodes) weight += node.weight, mean += node.weight * node.wavelength_nm;
    for (const FilterNode& node : nodes) variance += node.weight * std::pow(node.wavelength_nm - mean, 2);
    EXPECT_NEAR(weight, 1.0, 1e-12);
    EXPECT_NEAR(mean, 500.0, 1e-9);
    EXPECT_NEAR(2.0 * std::sqrt(2.0 * std::log(2.0) * variance), fwhm_nm, 1e-9);
    EXPECT_EQ(nodes[nodes.size() / 2].wavelength_nm, 500.0);
  }
}

// A camera's blue channel, 460 nm and 70 nm wide: 17 nodes reach 6.9 standard deviations down, to 255 nm. The
// light beyond 350 nm is 1e-4 of all (the normal distribution beyond 3.7 standard deviations); a channel
// whose tails hold more than a thousandth keeps its nodes there.
TEST(FilterNodes, LeaveOutTailsBeyondTheSpectra) {
  const std::vector<FilterNode> nodes = FilterNodes({460.0, 70.0});
  EXPECT_GE(nodes.front().wavelength_nm, 350.0);
  EXPECT_EQ(nodes[nodes.size() / 2].wavelength_nm, 460.0);
  double weight = 0.0, variance = 0.0;
  for (const FilterNode& node : nodes) weight += node.weight;
  for (const FilterNode& node : nodes) variance += node.weight * std::pow(node.wavelength_nm - 460.0, 2);
  EXPECT_NEAR(weight, 1.0, 1e-12);
  EXPECT_NEAR(2.0 * std::sqrt(2.0 * std::log(2.0) * variance), 70.0, 0.3);
  EXPECT_LT(FilterNodes({400.0, 80.0}).front().wavelength_nm, 350.0);
}

// The full tables' totals, which were fitted as profiles; "exact" has a ballistic part and two R2.
TEST(BandTotals, AreTheTotalsOfTheFullTables) {
  for (const char* source : {"multipole", "exact"}) {
    const BandTables& full = TestTables(560, source);
    const BandTables totals = BuildBandTotals(TestSource(source), 560, TissueConfig{});
    for (const double mu_a_e : {0.03, 0.5, 5.0}) {
      for (const double mu_a_d : {0.02, 0.3, 3.0}) {
        const double expected = full.TotalReflectance(mu_a_e, mu_a_d, 0.0175);
        EXPECT_NEAR(totals.TotalReflectance(mu_a_e, mu_a_d, 0.0175), expected, 3e-4 * expected)
            << source << ' ' << mu_a_e << ' ' << mu_a_d;
      }
    }
  }
}

// BandTables::TotalReflectance in double, against the float columns that pixels read.
TEST(LocalTotals, AreTheTablesClosedForm) {
  for (const char* source : {"multipole", "exact"}) {
    const BandTables& tables = TestTables(560, source);
    const LocalTotals totals(tables);
    EXPECT_EQ(totals.has_ballistic(), std::string(source) == "exact");
    for (const float mu_a_e : {0.004f, 0.5f, 5.0f, 300.0f}) {
      for (const float mu_a_d : {0.02f, 3.0f}) {
        for (const double p : {0.0, 0.0175, 1.0}) {
          const float found = totals.Reflectance(PositionInTable(mu_a_e), PositionInTable(mu_a_d),
                                                 static_cast<float>(std::exp(-p)));
          EXPECT_NEAR(found, tables.TotalReflectance(mu_a_e, mu_a_d, p), 2e-6)
              << mu_a_e << ' ' << mu_a_d << ' ' << p;
        }
      }
    }
  }
}

// [D08 7] sums four terms for blue light and five for green and red.
TEST(AutomaticTerms, AreAboutThePapers) {
  const Band bands[] = {{400.0, 0.0}, {470.0, 0.0}, {540.0, 0.0}, {645.0, 0.0}};
  const std::vector<BandOptics> optics =
      BuildBandOptics(TestChromophores(), TestSource(), TissueConfig{}, bands, false, {});
  int last = 2;
  for (const BandOptics& band : optics) {
    const int terms = AutomaticTerms(band, TissueConfig{});
    EXPECT_GE(terms, last) << band.band.wavelength_nm;
    EXPECT_LE(terms, 6) << band.band.wavelength_nm;
    last = terms;
  }
  EXPECT_GE(last, 4);
}

}  // namespace
}  // namespace dermap
