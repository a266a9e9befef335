// SPDX-License-Identifier: Apache-2.0
// Evidence of residuals whose statistics are known.
#include "fit/spectra/model_choice.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace dermap {
namespace {

std::vector<double> Correlated(double rho, double sigma, int count, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  std::vector<double> values{normal(random)};
  for (int i = 1; i < count; ++i)
    values.push_back(rho * values.back() + std::sqrt(1 - rho * rho) * normal(random));
  for (double& value : values) value *= sigma;
  return values;
}

// Source: Bayley and Hammersley's n (1 - rho) / (1 + rho): all of them where they are independent, a third at
// 0.5.
TEST(EffectiveCount, CountsIndependentResiduals) {
  EXPECT_NEAR(EffectiveCount(Correlated(0.0, 1.0, 4000, 1)) / 4000.0, 1.0, 0.06);
  EXPECT_NEAR(EffectiveCount(Correlated(0.5, 1.0, 4000, 2)) / 4000.0, 1.0 / 3.0, 0.03);
  EXPECT_EQ(EffectiveCount(std::vector<double>(33, 0.0)), 33.0);
}

// Source: residuals of standard deviation 0.005 under a noise of 0.003 leave sqrt(25 - 9) = 0.004.
TEST(WeighEvidence, FindsWhatTheNoiseDoesNotExplain) {
  const auto residuals = Correlated(0.0, 0.005, 4000, 3);
  const std::vector<double> noise(residuals.size(), 0.003);
  EXPECT_NEAR(WeighEvidence(residuals, noise, 5, 4000).discrepancy, 0.004, 1e-4);
  const std::vector<double> louder(residuals.size(), 0.006);
  EXPECT_NEAR(WeighEvidence(residuals, louder, 5, 4000).discrepancy, 0.0, 5e-4);
}

// Source: Schwarz: one parameter more must lower -2 ln L by ln n.
TEST(WeighEvidence, AsksLnNForAParameter) {
  const auto residuals = Correlated(0.0, 0.005, 33, 4);
  const std::vector<double> noise(residuals.size(), 0.001);
  const Evidence five = WeighEvidence(residuals, noise, 5, 20.0),
                 six = WeighEvidence(residuals, noise, 6, 20.0);
  EXPECT_NEAR(six.bic - five.bic, std::log(20.0), 1e-12);
  std::vector<double> halved = residuals;
  for (double& r : halved) r *= 0.5;
  EXPECT_LT(WeighEvidence(halved, noise, 6, 20.0).bic, five.bic);
}

}  // namespace
}  // namespace dermap
