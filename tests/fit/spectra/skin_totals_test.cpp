// SPDX-License-Identifier: Apache-2.0
// The table of exact totals between its samples.
#include "fit/spectra/skin_totals.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "common/optics/homogeneous_skin.h"
#include "fit/spectra/fit_spectra.h"

namespace dermap {
namespace {

// Source: the same discrete ordinates without a table (themselves within 1e-4 of adding-doubling). Held to
// 5e-4 of R and 5e-5 over the whole table, a hundredth of what real spectra are fitted to.
TEST(SkinTotals, AgreeWithTheSolverBetweenSamples) {
  const TissueConfig tissue = MeasuredTissue();
  const SkinTotals totals(tissue, {});
  std::mt19937 random(3);
  std::uniform_real_distribution<double> share;
  std::vector<SkinRow> rows;
  std::vector<std::array<double, 3>> places;
  for (int i = 0; i < 200; ++i) {
    std::array<double, 3> x{};
    for (int axis = 0; axis < 3; ++axis) {
      const GridAxis& a = SkinTotals::Axes()[axis];
      x[axis] = a.first + (a.last - a.first) * share(random);
    }
    const double mu_s = 1.0 + 20.0 * share(random);  // any: only ratios matter
    places.push_back(x);
    rows.push_back({.mu_a_epidermis = std::exp(x[1]) * mu_s,
                    .mu_a_dermis = std::exp(x[2]) * 0.5 * mu_s,
                    .junction_absorbance = tissue.junction_absorbance,
                    .mu_s_reduced_epidermis = mu_s,
                    .mu_s_reduced_dermis = 0.5 * mu_s,
                    .epidermis_thickness_mm = std::exp(x[0]) / mu_s});
  }
  const auto exact = HomogeneousSkin({}, tissue).Evaluate(rows, {});
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const double table = std::exp(totals.log_reflectance().At(places[i]).value), truth = exact[i].reflectance;
    EXPECT_NEAR(table, truth, 5e-4 * truth + 5e-5)
        << places[i][0] << ' ' << places[i][1] << ' ' << places[i][2];
  }
}

}  // namespace
}  // namespace dermap
