// SPDX-License-Identifier: Apache-2.0
// Optical properties of the two layers from the parameters of table 1 [D08 eq. 10-12], in 1/mm and mm.
#pragma once

#include <filesystem>

#include "common/spectra/sampled_spectrum.h"
#include "common/tissue/parameters.h"

namespace dermap {

// What a scene or a rig may change: the [tissue] table of a configuration file.
struct TissueConfig {
  double epidermis_thickness_mm = 0.25;  // [D08 5.2]
  double n_epidermis = 1.4;
  double n_dermis = 1.38;
  double n_outside = 1.0;
  double oxygenation_epidermis = 0.75;  // gamma_e
  double oxygenation_dermis = 0.75;     // gamma_d
  double junction_absorbance = 0.0175;  // base value of P [D08 5.3]
  double scattering_amplitude = 1.0;    // factor on [D08 eq. 12]
  double scattering_slope = 0.0;        // extra exponent: (wavelength / 550 nm)^slope
  double anisotropy = 0.0;              // g; by definition 0 with mu_s'
};
// Throws InputError naming the key, the value and the allowed range.
void Validate(const TissueConfig& config);

// Absorption of everything in [D08 eq. 10-11] at one wavelength, 1/mm at volume fraction 1 (carotene: per
// g/L). mu_a of each layer is linear in these; the derivatives are therefore exact and cheap.
struct Absorbers {
  double wavelength_nm = 0.0;
  double eumelanin = 0.0;
  double pheomelanin = 0.0;
  double blood_epidermis = 0.0;  // oxygenation already mixed in
  double blood_dermis = 0.0;
  double carotene = 0.0;
  double baseline = 0.0;

  double MuAEpidermis(
      const ParameterVector& p) const;               // [D08 eq. 10], with the plus sign that the draft lacks
  double MuADermis(const ParameterVector& p) const;  // [D08 eq. 11]
  ParameterVector MuAEpidermisGradient(const ParameterVector& p) const;  // d mu_a / d p
  ParameterVector MuADermisGradient(const ParameterVector& p) const;
};

// The published spectra, read once from a folder (config/spectra).
class Chromophores {
 public:
  explicit Chromophores(const std::filesystem::path& spectra_dir);
  // Throws InputError outside 350-1000 nm.
  Absorbers At(double wavelength_nm, const TissueConfig& config) const;

 private:
  SampledSpectrum oxyhemoglobin_;    // 1/mm of whole blood at 150 g/L
  SampledSpectrum deoxyhemoglobin_;  // 1/mm of whole blood at 150 g/L
  SampledSpectrum carotene_;         // 1/mm per g/L, 0 from 540 nm up
};

double EumelaninAbsorption(double wavelength_nm);    // 6.6e10 * lambda^-3.33
double PheomelaninAbsorption(double wavelength_nm);  // 2.9e14 * lambda^-4.75
double BaselineAbsorption(double wavelength_nm);     // 0.0244 + 8.53 exp(-(lambda - 154)/66.2)

// Reduced scattering, 1/mm [D08 eq. 12]; the dermis has half of the epidermis's.
double ReducedScatteringEpidermis(double wavelength_nm, const TissueConfig& config);
double ReducedScatteringDermis(double wavelength_nm, const TissueConfig& config);

// config/ of this build or installation: $DERMAP_CONFIG_DIR, else beside the executable. Throws InputError.
std::filesystem::path ConfigDirectory();

}  // namespace dermap
