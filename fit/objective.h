// SPDX-License-Identifier: Apache-2.0
// How far a rendered patch is from the measured one.
#pragma once

#include <cstddef>
#include <vector>

#include "common/core/image.h"
#include "fit/prepare.h"

namespace dermap {

// Share of the free parameters that follow the noise: skin blurs, so the smaller the pixels, the less of a
// pixel's own noise can be followed. Fits once more with noise added found, of 5 parameters and 8 bands in
// the three recorded samples, 0.69 to 0.80 at pixels of 0.234 mm, 0.46 to 0.59 at 0.117 mm, 0.21 to 0.42 at
// 0.059 mm and 0.22 to 0.26 at 0.029 mm. Between and beyond them a power law, held within what was measured.
double AdaptedShare(double pixel_size_mm);

struct Misfit {
  double chi2 = 0.0;           // sum of ((measured - predicted) / sigma)^2 over the data of the fitted pixels
  std::size_t data_count = 0;  // as many
  std::size_t pixel_count = 0;  // fitted pixels
  double adapted_share = 0.0;   // AdaptedShare of the data's pixels
  double rms = 0.0;             // of measured - predicted, reflectance
  std::vector<double> rms_per_band;
  Plane<double> chi2_map;  // the sum over the bands of each pixel; 0 where masked

  // Data less the parameters that a fit of `free_count` a pixel is expected to adapt to.
  double DegreesOfFreedom(int free_count) const;
  double Chi2PerDatum() const { return data_count > 0 ? chi2 / static_cast<double>(data_count) : 0.0; }
  double Chi2PerDegree(int free_count) const { return chi2 / DegreesOfFreedom(free_count); }
};

Misfit Evaluate(const FitData& data, const std::vector<PlaneF>& predicted);

// measured - predicted; NaN where missing.
std::vector<PlaneF> Residual(const FitData& data, const std::vector<PlaneF>& predicted);

// One datum: how many standard deviations it lies above what is predicted, and by how many less for each unit
// that the logarithm of the prediction rises. Reflectance is close to an exponential of absorption, so
// Gauss-Newton steps in its logarithm reach further.
struct LogResidual {
  double residual;
  double weight;
};
// (measured - predicted) / sigma where both are within four sigma or a fifth of each other: the logarithm of a
// noisy datum would be biased by half its relative variance, and of a patch's mean that is many sigma. Beyond,
// it goes on as the logarithm, with the same slope.
LogResidual LogResidualOf(double measured, double sigma, double predicted) noexcept;

}  // namespace dermap
