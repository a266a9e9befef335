// SPDX-License-Identifier: Apache-2.0
// Bands as weighted wavelengths, and the optical constants at each of these.
#include "fit/spectra/spectrum_model.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "common/optics/fresnel.h"

namespace dermap {
namespace {

constexpr double kReference_nm = 550.0;  // where the slope of scattering changes nothing
constexpr double kFirst_nm = 350.0, kLast_nm = 1000.0;

// The tables take the larger part of the time: progress runs over both.
ProgressFunction Part(const ProgressFunction& whole, double from, double to) {
  if (!whole) return {};
  return [=](double fraction) { whole(from + (to - from) * fraction); };
}

}  // namespace

SpectrumModel::SpectrumModel(const Instrument& instrument, const TissueConfig& tissue,
                             const Chromophores& chromophores, std::vector<double> wavelengths_nm,
                             const ProgressFunction& progress)
    : wavelengths_nm_(std::move(wavelengths_nm)),
      totals_(tissue, Part(progress, 0.0, instrument.aperture.IsFinite() ? 0.4 : 1.0)) {
  if (instrument.aperture.IsFinite()) edge_.emplace(instrument.aperture, tissue, Part(progress, 0.4, 1.0));
  if (instrument.specular_included) {
    specular_ = FresnelReflectance(1.0, tissue.n_outside, tissue.n_epidermis);
  }
  TissueConfig oxygenated = tissue, deoxygenated = tissue, published = tissue;
  oxygenated.oxygenation_dermis = 1.0;
  deoxygenated.oxygenation_dermis = 0.0;
  published.scattering_amplitude = 1.0;
  published.scattering_slope = 0.0;
  std::map<double, int> known;
  const auto point_at = [&](double wavelength_nm) {
    const double nm = std::clamp(wavelength_nm, kFirst_nm, kLast_nm);
    const auto [at, is_new] = known.try_emplace(nm, static_cast<int>(points_.size()));
    if (is_new) {
      const Absorbers with = chromophores.At(nm, oxygenated), without = chromophores.At(nm, deoxygenated);
      points_.push_back({.eumelanin = with.eumelanin,
                         .pheomelanin = with.pheomelanin,
                         .oxyhemoglobin = with.blood_dermis,
                         .deoxyhemoglobin = without.blood_dermis,
                         .carotene = with.carotene,
                         .baseline = with.baseline,
                         .mu_s_reduced = ReducedScatteringEpidermis(nm, published),
                         .log_relative_wavelength = std::log(nm / kReference_nm)});
    }
    return at->second;
  };
  // A triangle by three points: its mean and its variance, fwhm^2 / 6. Bands one width apart share two of
  // them.
  for (const double wavelength_nm : wavelengths_nm_) {
    std::vector<Share> band;
    if (instrument.fwhm_nm > 0.0) {
      for (const double offset : {-0.5, 0.0, 0.5}) {
        band.push_back({point_at(wavelength_nm + offset * instrument.fwhm_nm), 1.0 / 3.0});
      }
    } else {
      band.push_back({point_at(wavelength_nm), 1.0});
    }
    bands_.push_back(std::move(band));
  }
}

}  // namespace dermap
