// SPDX-License-Identifier: Apache-2.0
// A table of measured spectra in, the parameters of each skin out, with the model that each spectrum needs.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/core/progress.h"
#include "fit/spectra/spectra_table.h"
#include "fit/spectra/spectrum_fit.h"

namespace dermap {

struct SpectraOptions {
  Instrument instrument;
  SpectrumNoise noise;  // where the spectra do not say their own
  TissueConfig tissue = MeasuredTissue();
  std::string model = "auto";  // or one of SkinModelNames()
};

struct SpectraFit {
  MeasuredSpectra spectra;
  std::vector<SpectrumFit> fits;  // one a row
  SpectraOptions options;
  double seconds = 0.0;

  bool Converged() const;                    // every chosen model
  double MedianRms() const;                  // over the spectra, of the chosen models
  std::vector<double> MeanResidual() const;  // measured - predicted, of the chosen models, one a wavelength
  std::vector<int> ChosenCounts() const;     // how often each of SkinModelNames() was chosen
  std::vector<std::vector<double>> RmsByModel()
      const;  // of each of SkinModelNames(), every spectrum; empty: not tried
};

SpectraFit FitSpectra(MeasuredSpectra spectra, const SpectraOptions& options,
                      const Chromophores& chromophores, const ProgressFunction& progress = {});

double MedianOf(std::vector<double> values);  // 0 of none

}  // namespace dermap
