// SPDX-License-Identifier: Apache-2.0
// Absorption and reduced scattering of epidermis and dermis [D08 eq. 10-12], in 1/mm.
#include "common/tissue/tissue.h"

#include <spdlog/fmt/fmt.h>

#include <cmath>
#include <numbers>
#include <string_view>
#include <utility>
#include <vector>

#include "common/core/error.h"

namespace dermap {
namespace {

constexpr double kFirstWavelength_nm = 350.0;
constexpr double kLastWavelength_nm = 1000.0;
constexpr double kReferenceWavelength_nm = 550.0;  // where scattering_slope changes nothing

constexpr double kHemoglobinInBlood_g_per_l = 150.0;
constexpr double kHemoglobinMolarMass_g_per_mol = 64500.0;
constexpr double kCaroteneMolarMass_g_per_mol = 536.87;
constexpr double kCaroteneNoiseFrom_nm = 540.0;

// Decadic molar extinction (1/cm per mol/L) to Napierian absorption, 1/mm.
double AbsorptionFromExtinction(double extinction, double concentration_g_per_l,
                                double molar_mass_g_per_mol) {
  constexpr double kMmPerCm = 10.0;
  return std::numbers::ln10 * extinction * concentration_g_per_l / molar_mass_g_per_mol / kMmPerCm;
}

SampledSpectrum ReadBlood(const std::filesystem::path& spectra_dir, const std::string& column) {
  const auto extinction = ReadSpectrumCsv(spectra_dir / "hemoglobin_prahl_1998.csv", column);
  auto values = extinction.values();
  for (double& value : values) {
    value = AbsorptionFromExtinction(value, kHemoglobinInBlood_g_per_l, kHemoglobinMolarMass_g_per_mol);
  }
  return SampledSpectrum(extinction.wavelengths_nm(), std::move(values));
}

// Noise is cut off: 0 from 540 nm up, and nowhere below 0.
SampledSpectrum ReadCarotene(const std::filesystem::path& spectra_dir) {
  const auto extinction = ReadSpectrumCsv(spectra_dir / "beta_carotene_photochemcad.csv", "extinction");
  std::vector<double> wavelengths_nm, values;
  for (std::size_t i = 0; i < extinction.values().size(); ++i) {
    if (extinction.wavelengths_nm()[i] >= kCaroteneNoiseFrom_nm) break;
    wavelengths_nm.push_back(extinction.wavelengths_nm()[i]);
    values.push_back(
        AbsorptionFromExtinction(std::fmax(extinction.values()[i], 0.0), 1.0, kCaroteneMolarMass_g_per_mol));
  }
  for (const double zero_at_nm : {kCaroteneNoiseFrom_nm, kLastWavelength_nm}) {
    wavelengths_nm.push_back(zero_at_nm);
    values.push_back(0.0);
  }
  return SampledSpectrum(std::move(wavelengths_nm), std::move(values));
}

void CheckRange(std::string_view key, double value, double lower, double upper) {
  if (value >= lower && value <= upper) return;
  throw InputError(
      fmt::format("[tissue] {} is {}; it must lie from {} to {}. Correct it.", key, value, lower, upper));
}

}  // namespace

void Validate(const TissueConfig& config) {
  CheckRange("epidermis_thickness_mm", config.epidermis_thickness_mm, 0.01, 2.0);
  CheckRange("n_epidermis", config.n_epidermis, 1.0, 2.0);
  CheckRange("n_dermis", config.n_dermis, 1.0, 2.0);
  CheckRange("n_outside", config.n_outside, 1.0, 2.0);
  CheckRange("oxygenation_epidermis", config.oxygenation_epidermis, 0.0, 1.0);
  CheckRange("oxygenation_dermis", config.oxygenation_dermis, 0.0, 1.0);
  CheckRange("junction_absorbance", config.junction_absorbance, 0.0, 20.0);
  CheckRange("scattering_amplitude", config.scattering_amplitude, 0.05, 20.0);
  CheckRange("scattering_slope", config.scattering_slope, -10.0, 10.0);
  CheckRange("anisotropy", config.anisotropy, 0.0, 0.99);
}

// [D08 eq. 10]; the draft lacks the plus sign between melanin and hemoglobin, and its C_b is C_bc.
double Absorbers::MuAEpidermis(const ParameterVector& p) const {
  const auto [C_m, beta_m, C_he, C_bc, C_hd] = p;
  return C_m * (beta_m * eumelanin + (1.0 - beta_m) * pheomelanin)  //
         + C_he * blood_epidermis                                   //
         + C_bc * carotene + (1.0 - C_m - C_he - C_bc) * baseline;
}

double Absorbers::MuADermis(const ParameterVector& p) const {  // [D08 eq. 11]
  const double C_hd = p[static_cast<int>(Parameter::kC_hd)];
  return C_hd * blood_dermis + (1.0 - C_hd) * baseline;
}

ParameterVector Absorbers::MuAEpidermisGradient(const ParameterVector& p) const {
  const auto [C_m, beta_m, C_he, C_bc, C_hd] = p;
  return {beta_m * eumelanin + (1.0 - beta_m) * pheomelanin - baseline,  // C_m
          C_m * (eumelanin - pheomelanin),                               // beta_m
          blood_epidermis - baseline,                                    // C_he
          carotene - baseline,                                           // C_bc
          0.0};                                                          // C_hd
}

ParameterVector Absorbers::MuADermisGradient(const ParameterVector&) const {
  return {0.0, 0.0, 0.0, 0.0, blood_dermis - baseline};
}

Chromophores::Chromophores(const std::filesystem::path& spectra_dir)
    : oxyhemoglobin_(ReadBlood(spectra_dir, "oxyhemoglobin")),
      deoxyhemoglobin_(ReadBlood(spectra_dir, "deoxyhemoglobin")),
      carotene_(ReadCarotene(spectra_dir)) {}

Absorbers Chromophores::At(double wavelength_nm, const TissueConfig& config) const {
  if (!(wavelength_nm >= kFirstWavelength_nm && wavelength_nm <= kLastWavelength_nm)) {
    throw InputError(fmt::format(
        "The absorption of skin is known from {} to {} nm, but {} nm was asked for; leave that band out.",
        kFirstWavelength_nm, kLastWavelength_nm, wavelength_nm));
  }
  const double oxy = oxyhemoglobin_.At(wavelength_nm);
  const double deoxy = deoxyhemoglobin_.At(wavelength_nm);
  const auto blood = [&](double gamma) { return gamma * oxy + (1.0 - gamma) * deoxy; };
  return {.wavelength_nm = wavelength_nm,
          .eumelanin = EumelaninAbsorption(wavelength_nm),
          .pheomelanin = PheomelaninAbsorption(wavelength_nm),
          .blood_epidermis = blood(config.oxygenation_epidermis),
          .blood_dermis = blood(config.oxygenation_dermis),
          .carotene = carotene_.At(wavelength_nm),
          .baseline = BaselineAbsorption(wavelength_nm)};
}

double EumelaninAbsorption(double wavelength_nm) {
  return 6.6e10 * std::pow(wavelength_nm, -3.33);
}

double PheomelaninAbsorption(double wavelength_nm) {
  return 2.9e14 * std::pow(wavelength_nm, -4.75);
}

double BaselineAbsorption(double wavelength_nm) {
  return 0.0244 + 8.53 * std::exp(-(wavelength_nm - 154.0) / 66.2);
}

double ReducedScatteringEpidermis(double wavelength_nm, const TissueConfig& config) {
  const double skin =
      14.74 * std::pow(wavelength_nm, -0.22) + 2.2e11 * std::pow(wavelength_nm, -4.0);  // [D08 eq. 12]
  return config.scattering_amplitude *
         std::pow(wavelength_nm / kReferenceWavelength_nm, config.scattering_slope) * skin;
}

double ReducedScatteringDermis(double wavelength_nm, const TissueConfig& config) {
  return 0.5 * ReducedScatteringEpidermis(wavelength_nm, config);
}

}  // namespace dermap
