// SPDX-License-Identifier: Apache-2.0
// Spectra of known skin.
#include "tests/fit/spectra/made_spectra.h"

#include <cmath>

#include "tests/reference/adding_doubling.h"

namespace dermap {

const Chromophores& TestChromophores() {
  static const Chromophores chromophores(ConfigDirectory() / "spectra");
  return chromophores;
}

std::vector<double> TestWavelengths() {
  std::vector<double> nm;
  for (int i = 0; i < 33; ++i) nm.push_back(400.0 + 10.0 * i);
  return nm;
}

const SpectrumModel& MonochromaticModel() {
  static const SpectrumModel model({.aperture = {}, .fwhm_nm = 0.0}, MeasuredTissue(), TestChromophores(),
                                   TestWavelengths(), {});
  return model;
}

SkinVector SkinWith(std::initializer_list<std::pair<SkinParameter, double>> values) {
  SkinVector skin = SkinModelFromName("core", MeasuredTissue()).fixed;
  for (const auto& [parameter, value] : values) skin[static_cast<int>(parameter)] = value;
  return skin;
}

std::vector<double> MadeSpectrum(const SkinVector& skin, const std::vector<double>& wavelengths_nm) {
  const auto [C_m, beta_m, C_he, C_bc, C_hd, gamma, amplitude, slope, thickness_mm, radius_mm, base,
              surface] = skin;
  constexpr double kAnisotropy = 0.8;
  std::vector<double> spectrum;
  for (const double nm : wavelengths_nm) {
    TissueConfig tissue;
    tissue.oxygenation_epidermis = tissue.oxygenation_dermis = gamma;
    const Absorbers at = TestChromophores().At(nm, tissue);
    const double melanin = beta_m * at.eumelanin + (1.0 - beta_m) * at.pheomelanin;
    const double depth = 2.0 * at.blood_dermis * radius_mm;
    const double packed = depth > 0.0 ? -std::expm1(-depth) / depth : 1.0;
    const double mu_s = amplitude * std::pow(nm / 550.0, slope) *
                        (14.74 * std::pow(nm, -0.22) + 2.2e11 * std::pow(nm, -4.0)) / (1.0 - kAnisotropy);
    const reference::LayerStack stack{
        1.0,
        {{.thickness_mm = thickness_mm,
          .mu_a = C_m * melanin + C_he * at.blood_epidermis + C_bc * at.carotene +
                  (1.0 - C_m - C_he - C_bc) * base * at.baseline,
          .mu_s = mu_s,
          .g = kAnisotropy,
          .n = 1.4,
          .absorber_below = 0.0175},
         {.mu_a = C_hd * at.blood_dermis * packed + (1.0 - C_hd) * base * at.baseline,
          .mu_s = 0.5 * mu_s,
          .g = kAnisotropy,
          .n = 1.38}},
        1.38};
    spectrum.push_back(reference::NormalIncidenceTotals(stack, 14).reflectance + surface);
  }
  return spectrum;
}

}  // namespace dermap
