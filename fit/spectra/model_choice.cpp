// SPDX-License-Identifier: Apache-2.0
// Likelihood of residuals whose variance is partly unknown.
#include "fit/spectra/model_choice.h"

#include <algorithm>
#include <cmath>

namespace dermap {
namespace {

// -2 ln L per residual, without its constant.
double MeanDeviance(std::span<const double> residuals, std::span<const double> sigma, double discrepancy) {
  double sum = 0.0;
  for (std::size_t i = 0; i < residuals.size(); ++i) {
    const double variance = sigma[i] * sigma[i] + discrepancy * discrepancy;
    sum += std::log(variance) + residuals[i] * residuals[i] / variance;
  }
  return sum / static_cast<double>(residuals.size());
}

}  // namespace

double EffectiveCount(std::span<const double> residuals) {
  const double count = static_cast<double>(residuals.size());
  double square = 0.0, product = 0.0;
  for (std::size_t i = 0; i < residuals.size(); ++i) {
    square += residuals[i] * residuals[i];
    if (i > 0) product += residuals[i] * residuals[i - 1];
  }
  const double rho = square > 0.0 ? std::clamp(product / square, 0.0, 0.8) : 0.0;
  return std::max(2.0, count * (1.0 - rho) / (1.0 + rho));
}

Evidence WeighEvidence(std::span<const double> residuals, std::span<const double> sigma,
                       std::size_t count_free, double effective_count) {
  Evidence evidence;
  for (const double r : residuals) evidence.rms += r * r;
  evidence.rms = std::sqrt(evidence.rms / static_cast<double>(residuals.size()));
  // The deviance falls to its minimum and rises again: golden section from no discrepancy to all of the
  // misfit.
  constexpr double kGolden = 0.6180339887498949;
  double low = 0.0, high = evidence.rms;
  for (const double r : residuals) high = std::max(high, std::abs(r));
  for (int i = 0; i < 60; ++i) {
    const double left = high - kGolden * (high - low), right = low + kGolden * (high - low);
    if (MeanDeviance(residuals, sigma, left) <= MeanDeviance(residuals, sigma, right)) {
      high = right;
    } else {
      low = left;
    }
  }
  evidence.discrepancy = 0.5 * (low + high);
  evidence.bic = effective_count * MeanDeviance(residuals, sigma, evidence.discrepancy) +
                 static_cast<double>(count_free) * std::log(effective_count);
  return evidence;
}

}  // namespace dermap
