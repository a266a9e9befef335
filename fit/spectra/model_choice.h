// SPDX-License-Identifier: Apache-2.0
// How much evidence residuals hold for a model: the Bayesian information criterion with the noise model.
#pragma once

#include <cstddef>
#include <span>

namespace dermap {

// n (1 - rho) / (1 + rho) with rho the correlation of neighbouring residuals (0 to 0.8), at least 2 [Bayley
// and Hammersley 1946, for a process that remembers one step].
double EffectiveCount(std::span<const double> residuals);

struct Evidence {
  double rms = 0.0;
  double discrepancy = 0.0;  // standard deviation, see below
  double bic = 0.0;
};
// Residuals are noise and what the model lacks: their variance is sigma^2 + discrepancy^2, with the
// discrepancy that makes them likeliest. bic = -2 ln L + count_free ln(effective_count), -2 ln L over
// `effective_count` of the residuals. A perfect model has a bic of noise alone; without the discrepancy a low
// noise would always ask for the largest model.
Evidence WeighEvidence(std::span<const double> residuals, std::span<const double> sigma,
                       std::size_t count_free, double effective_count);

}  // namespace dermap
