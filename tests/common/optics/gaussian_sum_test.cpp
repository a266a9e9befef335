// SPDX-License-Identifier: Apache-2.0
// Sums of Gaussians: known sums are found again, exact totals, and profiles in real space.
#include "common/optics/gaussian_sum.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <numeric>

#include "common/optics/multipole.h"
#include "tests/common/optics/dipole_sum.h"

namespace dermap {
namespace {

double Sum(const GaussianWeights& weights) {
  return std::accumulate(weights.begin(), weights.end(), 0.0);
}

// The weights that made the transform: well separated Gaussians are found again, and nothing beside them.
TEST(FitGaussianSum, FindsKnownWeights) {
  const auto k = TableFrequencies_per_mm();
  GaussianWeights known{};
  known[2] = 0.125f;
  known[7] = 0.25f;
  known[13] = 0.0625f;
  std::vector<double> transform;
  for (const double f : k) transform.push_back(GaussianSumTransform(known, f));
  const auto found = FitGaussianSum(k, transform);
  for (int i = 0; i < kGaussianCount; ++i) EXPECT_NEAR(found[i], known[i], 2e-6) << i;
}

// [D08 7] with the unit mended: 0.0001 mm^2 is the smallest variance and each next one is twice the last;
// transform of a Gaussian of variance v per axis: exp(-v k^2/2).
TEST(GaussianSum, VariancesDouble) {
  EXPECT_DOUBLE_EQ(GaussianVariance_mm2(0), 0.0001);
  EXPECT_DOUBLE_EQ(GaussianVariance_mm2(17), 13.1072);
  GaussianWeights one{};
  one[10] = 2.0f;
  EXPECT_NEAR(GaussianSumTransform(one, 3.0), 2.0 * std::exp(-0.1024 * 9.0 / 2.0), 1e-12);
}

// A response without light, or with less than none, has no Gaussians: never a negative total, never NaN.
TEST(FitGaussianSum, TakesNegativeTotalsAsZero) {
  const auto k = TableFrequencies_per_mm();
  std::vector<double> transform(k.size(), -0.1);
  EXPECT_EQ(FitGaussianSum(k, transform), GaussianWeights{});
  transform.assign(k.size(), 0.0);
  EXPECT_EQ(FitGaussianSum(k, transform), GaussianWeights{});
}

// The claim of the header, for a shape that no sum of Gaussians is: a flat transform (a point of light) and a
// disc.
TEST(FitGaussianSum, KeepsTheTotalWhateverTheShape) {
  const auto k = TableFrequencies_per_mm();
  std::vector<double> point(k.size(), 0.4), disc;
  for (const double f : k) disc.push_back(f == 0.0 ? 0.3 : 0.3 * 2.0 * std::cyl_bessel_j(1.0, f) / f);
  EXPECT_NEAR(Sum(FitGaussianSum(k, point)), 0.4, 1e-7);
  EXPECT_NEAR(Sum(FitGaussianSum(k, disc)), 0.3, 1e-7);
  for (const float weight : FitGaussianSum(k, disc)) EXPECT_GE(weight, 0.0f);
}

// A fit that starts from a neighbour's weights ends where any fit ends.
TEST(GaussianFitter, StartDoesNotMatter) {
  const auto k = TableFrequencies_per_mm();
  const GaussianFitter fitter(k);
  const auto transform = [&](double mu_a) {
    std::vector<double> values;
    for (const double f : k)
      values.push_back(MultipoleSlab({mu_a, 9.2, 1.4}, 0.25, 3.2, 1.07).Reflectance(f));
    return values;
  };
  const auto cold = fitter.Fit(transform(1.0));
  const auto warm = fitter.Fit(transform(1.0), fitter.Fit(transform(1.5)));
  for (const double f : k) EXPECT_NEAR(GaussianSumTransform(cold, f), GaussianSumTransform(warm, f), 1e-6);
}

// Source: the header, and least squares: fewer Gaussians keep the total and are further off the transform.
TEST(GaussianFitter, TakesEveryNthGaussian) {
  const auto k = TableFrequencies_per_mm();
  std::vector<double> transform;
  for (const double f : k)
    transform.push_back(MultipoleSlab({1.0, 9.2, 1.4}, 0.25, 3.2, 1.07).Reflectance(f));
  double last = 0.0;
  for (const int step : {1, 2, 3, 6}) {
    const GaussianWeights weights = GaussianFitter(k, step).Fit(transform);
    EXPECT_NEAR(Sum(weights), transform[0], 1e-7 * transform[0] + 1e-8);
    double square = 0.0;
    for (int i = 0; i < kGaussianCount; ++i) {
      if (i % step != 0) {
        EXPECT_EQ(weights[i], 0.0f) << step << ' ' << i;
      }
    }
    for (std::size_t i = 0; i < k.size(); ++i)
      square += std::pow(GaussianSumTransform(weights, k[i]) - transform[i], 2);
    EXPECT_GT(square, last) << step;
    last = square;
  }
}

// The multipole's sum of dipoles in real space, which the fit never saw: R(r) of the sum of Gaussians within
// 1 % from 0.03 to 1 mm (450 nm, melanin from fair to dark).
TEST(FitGaussianSum, HoldsTheProfileInRealSpace) {
  const auto k = TableFrequencies_per_mm();
  for (const double mu_a : {0.05, 1.0, 6.0}) {
    const MultipoleSlab slab({mu_a, 9.2, 1.4}, 0.25, 3.2, 1.07);
    std::vector<double> reflectance, transmittance;
    for (const double f : k) {
      reflectance.push_back(slab.Reflectance(f));
      transmittance.push_back(slab.Transmittance(f));
    }
    const auto r_weights = FitGaussianSum(k, reflectance), t_weights = FitGaussianSum(k, transmittance);
    const auto at = [](const GaussianWeights& weights, double r) {
      double sum = 0.0;
      for (int i = 0; i < kGaussianCount; ++i) {
        const double v = GaussianVariance_mm2(i);
        sum += weights[i] * std::exp(-0.5 * r * r / v) / (2.0 * std::numbers::pi * v);
      }
      return sum;
    };
    const DipoleSlab dipoles{mu_a, 9.2, 0.25, 3.2, 1.07};
    for (const double r : {0.03, 0.1, 0.2, 0.5}) {
      const double reflected = DipoleSumReflectance(dipoles, r),
                   transmitted = DipoleSumTransmittance(dipoles, r);
      EXPECT_NEAR(at(r_weights, r), reflected, 0.01 * reflected + 1e-4) << mu_a << " r " << r;
      EXPECT_NEAR(at(t_weights, r), transmitted, 0.01 * transmitted + 1e-4) << mu_a << " r " << r;
    }
  }
}

}  // namespace
}  // namespace dermap
