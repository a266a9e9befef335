// SPDX-License-Identifier: Apache-2.0
// Every spectrum by itself, in parallel.
#include "fit/spectra/fit_spectra.h"

#include <algorithm>
#include <chrono>
#include <mutex>

#include "common/core/parallel.h"

namespace dermap {
namespace {

constexpr double kTablesShare = 0.3;  // of the progress

std::vector<SkinModel> CandidatesOf(const SpectraOptions& options) {
  if (options.model == "auto") return SkinModels(options.tissue);
  return {SkinModelFromName(options.model, options.tissue)};
}

std::size_t IndexOf(const SkinModel& model) {
  const auto& names = SkinModelNames();
  return static_cast<std::size_t>(std::find(names.begin(), names.end(), model.name) - names.begin());
}

}  // namespace

SpectraFit FitSpectra(MeasuredSpectra spectra, const SpectraOptions& options,
                      const Chromophores& chromophores, const ProgressFunction& progress) {
  const auto start = std::chrono::steady_clock::now();
  const std::vector<SkinModel> candidates = CandidatesOf(options);
  const SpectrumModel model(options.instrument, options.tissue, chromophores, spectra.wavelengths_nm,
                            [&](double fraction) {
                              if (progress) progress(kTablesShare * fraction);
                            });
  SpectraFit result;
  result.fits.resize(spectra.rows.size());
  std::mutex drawing;
  std::size_t done = 0;
  ParallelFor(static_cast<int>(spectra.rows.size()), [&](int i) {
    const MeasuredSpectra::Row& row = spectra.rows[i];
    std::vector<double> sigma = row.sigma;
    for (std::size_t band = sigma.size(); band < row.reflectance.size(); ++band) {
      sigma.push_back(options.noise.Sigma(row.reflectance[band]));
    }
    for (double& value : sigma) value = std::max(value, 1e-5);  // a weight, never infinite
    result.fits[i] = FitSpectrum(model, row.reflectance, sigma, candidates);
    const std::lock_guard lock(drawing);
    ++done;
    if (progress) {
      progress(kTablesShare +
               (1.0 - kTablesShare) * static_cast<double>(done) / static_cast<double>(spectra.rows.size()));
    }
  });
  result.spectra = std::move(spectra);
  result.options = options;
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return result;
}

bool SpectraFit::Converged() const {
  return std::all_of(fits.begin(), fits.end(), [](const SpectrumFit& fit) { return fit.best().converged; });
}

double SpectraFit::MedianRms() const {
  std::vector<double> rms;
  for (const SpectrumFit& fit : fits) rms.push_back(fit.best().rms);
  return MedianOf(std::move(rms));
}

std::vector<double> SpectraFit::MeanResidual() const {
  std::vector<double> mean(spectra.wavelengths_nm.size(), 0.0);
  for (std::size_t i = 0; i < fits.size(); ++i) {
    for (std::size_t band = 0; band < mean.size(); ++band) {
      mean[band] += (spectra.rows[i].reflectance[band] - fits[i].best().predicted[band]) /
                    static_cast<double>(fits.size());
    }
  }
  return mean;
}

std::vector<int> SpectraFit::ChosenCounts() const {
  std::vector<int> counts(SkinModelNames().size(), 0);
  for (const SpectrumFit& fit : fits) ++counts[IndexOf(fit.best().model)];
  return counts;
}

std::vector<std::vector<double>> SpectraFit::RmsByModel() const {
  std::vector<std::vector<double>> rms(SkinModelNames().size());
  for (const SpectrumFit& fit : fits) {
    for (const ModelFit& candidate : fit.candidates) {
      rms[IndexOf(candidate.model)].push_back(candidate.rms);
    }
  }
  return rms;
}

double MedianOf(std::vector<double> values) {
  if (values.empty()) return 0.0;
  std::sort(values.begin(), values.end());
  const std::size_t middle = values.size() / 2;
  return values.size() % 2 == 1 ? values[middle] : 0.5 * (values[middle - 1] + values[middle]);
}

}  // namespace dermap
