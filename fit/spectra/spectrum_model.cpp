// SPDX-License-Identifier: Apache-2.0
// Bands as weighted wavelengths, and the optical constants at each of these.
#include "fit/spectra/spectrum_model.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "common/optics/fresnel.h"
#include "common/transport/forward_model.h"

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
  exit_angle_factor_ = ExitAngleFactor(instrument.geometry, tissue.n_outside, tissue.n_epidermis);
  if (instrument.specular_included) {
    specular_ = FresnelReflectance(1.0, tissue.n_outside, tissue.n_epidermis);
  }
  std::map<double, int> known;
  const auto point_at = [&](double wavelength_nm) {
    const double nm = std::clamp(wavelength_nm, kFirst_nm, kLast_nm);
    const auto [at, is_new] = known.try_emplace(nm, static_cast<int>(points_.size()));
    if (is_new) points_.push_back(PointAt(nm, tissue, chromophores));
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

SpectrumModel::Point SpectrumModel::PointAt(double wavelength_nm, const TissueConfig& tissue,
                                            const Chromophores& chromophores) {
  TissueConfig oxygenated = tissue, deoxygenated = tissue, published = tissue;
  oxygenated.oxygenation_dermis = 1.0;
  deoxygenated.oxygenation_dermis = 0.0;
  published.scattering_amplitude = 1.0;
  published.scattering_slope = 0.0;
  const Absorbers with = chromophores.At(wavelength_nm, oxygenated);
  return {.eumelanin = with.eumelanin,
          .pheomelanin = with.pheomelanin,
          .oxyhemoglobin = with.blood_dermis,
          .deoxyhemoglobin = chromophores.At(wavelength_nm, deoxygenated).blood_dermis,
          .carotene = with.carotene,
          .baseline = with.baseline,
          .mu_s_reduced = ReducedScatteringEpidermis(wavelength_nm, published),
          .log_relative_wavelength = std::log(wavelength_nm / kReference_nm)};
}

}  // namespace dermap
