// SPDX-License-Identifier: Apache-2.0
// Profiles as sums of Gaussians, fitted on the side of their Fourier transforms.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "common/optics/profile_table.h"

namespace dermap {

// Fits many transforms known at the same frequencies; what depends on the frequencies alone is prepared once.
// May be used by many threads at a time.
class GaussianFitter {
 public:
  // k_per_mm[0] = 0, then ascending; at least kGaussianCount frequencies. By every `step`-th Gaussian, from
  // the narrowest; the others' weights stay 0.
  explicit GaussianFitter(std::span<const double> k_per_mm, int step = 1);
  ~GaussianFitter();

  // As FitGaussianSum: weights >= 0 whose sum is transform[0]; all 0 where transform[0] <= 0. `similar`: the
  // weights of a similar transform, which save time and change nothing else.
  GaussianWeights Fit(std::span<const double> transform, const GaussianWeights& similar = {}) const;

 private:
  struct Prepared;
  std::unique_ptr<const Prepared> prepared_;
};

// 2-D Fourier transform of a sum of Gaussians: sum of w_i exp(-v_i k^2 / 2).
double GaussianSumTransform(const GaussianWeights& weights, double k_per_mm);

}  // namespace dermap
