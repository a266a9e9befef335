// SPDX-License-Identifier: Apache-2.0
// One spectrum fitted with each model of measured skin, and the model that its evidence supports.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "fit/spectra/spectrum_model.h"

namespace dermap {

// One standard deviation of a measured reflectance R is sqrt(absolute^2 + (relative R)^2).
struct SpectrumNoise {
  double absolute = 0.001;
  double relative = 0.0;

  double Sigma(double reflectance) const { return std::hypot(absolute, relative * reflectance); }
};

struct ModelFit {
  SkinModel model;
  SkinVector skin{};
  SkinVector sigma{};             // one standard deviation; 0 for what is not free or ended at a bound
  std::vector<double> predicted;  // reflectance
  double rms = 0.0;               // of measured - predicted
  double discrepancy = 0.0;       // standard deviation of what the noise does not explain, the likeliest one
  double bic = 0.0;               // Bayesian information criterion
  std::vector<SkinParameter> at_bound, not_identifiable;
  bool converged = false;
};

struct SpectrumFit {
  std::vector<ModelFit> candidates;  // as asked for
  std::size_t chosen = 0;            // of least bic
  // Residuals of neighbouring bands are alike, so that a spectrum holds less evidence than it has bands.
  double effective_count = 0.0;

  const ModelFit& best() const { return candidates[chosen]; }
};

// `sigma`: noise of each wavelength. Several starts for each model, Levenberg-Marquardt within the bounds.
SpectrumFit FitSpectrum(const SpectrumModel& model, std::span<const double> reflectance,
                        std::span<const double> sigma, std::span<const SkinModel> candidates);

}  // namespace dermap
