// SPDX-License-Identifier: Apache-2.0
// Optical properties of the layers against values worked out by hand from the published tables and power
// laws.
#include "common/tissue/tissue.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>

#include <cmath>
#include <functional>

#include "common/core/error.h"

namespace dermap {
namespace {

using testing::HasSubstr;

class Tissue : public testing::Test {
 protected:
  static Absorbers At(double wavelength_nm, const TissueConfig& config = {}) {
    static const Chromophores chromophores(ConfigDirectory() / "spectra");
    return chromophores.At(wavelength_nm, config);
  }
};

// By hand: 6.6e10 * 450^-3.33, 2.9e14 * 450^-4.75, 0.0244 + 8.53 exp(-(450 - 154)/66.2), and the same at 550
// nm.
TEST_F(Tissue, MelaninAndBaselineFollowTheirFormulas) {
  EXPECT_NEAR(EumelaninAbsorption(450.0), 96.4598, 1e-3);
  EXPECT_NEAR(PheomelaninAbsorption(450.0), 72.3833, 1e-3);
  EXPECT_NEAR(BaselineAbsorption(450.0), 0.121919, 1e-5);
  EXPECT_NEAR(EumelaninAbsorption(550.0), 49.4466, 1e-3);
  EXPECT_NEAR(PheomelaninAbsorption(550.0), 27.9046, 1e-3);
  EXPECT_NEAR(BaselineAbsorption(550.0), 0.0459305, 1e-6);
}

// Prahl's table at 450 nm: 62816 and 103292 per cm per M; ln(10) * 150/64500/10 of them is 33.637 and 55.311
// per mm. PhotochemCAD at 450 nm: 138711 per cm per M; ln(10)/536.87/10 of it is 59.4916 per mm per g/L.
TEST_F(Tissue, BloodAndCaroteneAreConvertedFromMolarExtinction) {
  TissueConfig config;
  config.oxygenation_epidermis = 1.0;
  config.oxygenation_dermis = 0.0;
  const auto absorbers = At(450.0, config);
  EXPECT_NEAR(absorbers.blood_epidermis, 33.637, 1e-3);
  EXPECT_NEAR(absorbers.blood_dermis, 55.3113, 1e-3);
  EXPECT_NEAR(absorbers.carotene, 59.4916, 1e-3);
}

// A quarter deoxygenated at 600 nm, by hand: 0.75 * 1.71355 + 0.25 * 7.85942 = 3.25002 per mm (3200, 14677.2
// per cm/M).
TEST_F(Tissue, OxygenationMixesTheTwoHemoglobins) {
  EXPECT_NEAR(At(600.0).blood_epidermis, 3.25002, 1e-4);
  EXPECT_NEAR(At(600.0).blood_dermis, 3.25002, 1e-4);
}

// The table's own sample at 538 nm is negative and from 540 nm up it is noise: neither may reach the tissue.
TEST_F(Tissue, NoiseOfCaroteneIsCutOff) {
  EXPECT_EQ(At(538.0).carotene, 0.0);
  for (double nm = 350.0; nm <= 1000.0; nm += 0.5) EXPECT_GE(At(nm).carotene, 0.0) << nm;
  for (double nm = 540.0; nm <= 1000.0; nm += 0.5) EXPECT_EQ(At(nm).carotene, 0.0) << nm;
  EXPECT_GT(At(539.0).carotene, 0.5);
}

// By hand at 450 nm for average skin (C_m 0.06, beta_m 0.62, C_he 0.005, C_bc 0.01, C_hd 0.03, oxygenation
// 0.75): epidermis 5.238644 melanin + 0.195278 blood + 0.594916 carotene + 0.112775 baseline, dermis 1.171667
// + 0.118261. Without the plus sign that [D08 eq. 10] lacks, melanin would multiply blood instead.
TEST_F(Tissue, AverageSkinAt450nm) {
  const auto absorbers = At(450.0);
  EXPECT_NEAR(absorbers.MuAEpidermis(AverageSkin()), 6.141613, 1e-4);
  EXPECT_NEAR(absorbers.MuADermis(AverageSkin()), 1.289928, 1e-4);
}

// Each absorber alone at volume fraction 1 leaves nothing of the others: eq. 10 and 11 read term by term.
TEST_F(Tissue, TermsAddUpOneByOne) {
  const Absorbers a{.wavelength_nm = 500.0,
                    .eumelanin = 2.0,
                    .pheomelanin = 3.0,
                    .blood_epidermis = 5.0,
                    .blood_dermis = 7.0,
                    .carotene = 11.0,
                    .baseline = 13.0};
  EXPECT_DOUBLE_EQ(a.MuAEpidermis({1.0, 1.0, 0.0, 0.0, 0.0}), 2.0);
  EXPECT_DOUBLE_EQ(a.MuAEpidermis({1.0, 0.0, 0.0, 0.0, 0.0}), 3.0);
  EXPECT_DOUBLE_EQ(a.MuAEpidermis({0.0, 0.5, 1.0, 0.0, 0.0}), 5.0);
  EXPECT_DOUBLE_EQ(a.MuAEpidermis({0.0, 0.5, 0.0, 1.0, 0.0}), 11.0);
  EXPECT_DOUBLE_EQ(a.MuAEpidermis({0.0, 0.5, 0.0, 0.0, 1.0}), 13.0);
  EXPECT_DOUBLE_EQ(a.MuADermis({0.5, 0.5, 0.5, 0.5, 0.0}), 13.0);
  EXPECT_DOUBLE_EQ(a.MuADermis({0.5, 0.5, 0.5, 0.5, 1.0}), 7.0);
}

// Central differences; mu_a is at most bilinear, so they are exact but for rounding.
TEST_F(Tissue, GradientsAreDerivatives) {
  const auto absorbers = At(480.0);
  const ParameterVector p{0.2, 0.3, 0.02, 0.03, 0.06};
  const auto epidermis = absorbers.MuAEpidermisGradient(p);
  const auto dermis = absorbers.MuADermisGradient(p);
  for (int i = 0; i < kParameterCount; ++i) {
    constexpr double kStep = 1e-3;
    auto above = p, below = p;
    above[i] += kStep;
    below[i] -= kStep;
    EXPECT_NEAR(epidermis[i], (absorbers.MuAEpidermis(above) - absorbers.MuAEpidermis(below)) / (2 * kStep),
                1e-8);
    EXPECT_NEAR(dermis[i], (absorbers.MuADermis(above) - absorbers.MuADermis(below)) / (2 * kStep), 1e-8);
  }
}

// [D08 eq. 12] at 550 nm by hand: 14.74 * 550^-0.22 + 2.2e11 * 550^-4 = 6.0823 per mm, the dermis half of it.
// Close to what Salomatina et al. 2006 measured ex vivo (5.84 and 3.74 per mm).
TEST_F(Tissue, ReducedScatteringIsEquation12) {
  EXPECT_NEAR(ReducedScatteringEpidermis(550.0, {}), 6.082258, 1e-5);
  EXPECT_NEAR(ReducedScatteringDermis(550.0, {}), 3.041129, 1e-5);
  EXPECT_NEAR(ReducedScatteringEpidermis(450.0, {}), 9.209101, 1e-5);
}

// By hand: twice as much at every wavelength, and (450/550)^-1 = 1.2222 more at 450 nm, none at 550 nm.
TEST_F(Tissue, ScatteringAmplitudeAndSlopeScaleEquation12) {
  TissueConfig config;
  config.scattering_amplitude = 2.0;
  config.scattering_slope = -1.0;
  EXPECT_NEAR(ReducedScatteringEpidermis(550.0, config), 2 * 6.082258, 1e-5);
  EXPECT_NEAR(ReducedScatteringEpidermis(450.0, config), 2 * 9.209101 * 550.0 / 450.0, 1e-4);
}

// The claim of the header: known from 350 to 1000 nm, and nowhere else.
TEST_F(Tissue, RefusesWavelengthsWithoutData) {
  EXPECT_NO_THROW(At(350.0));
  EXPECT_NO_THROW(At(1000.0));
  EXPECT_THROW(At(349.9), InputError);
  EXPECT_THROW(At(1000.1), InputError);
  EXPECT_THROW(At(std::nan("")), InputError);
}

// House rule: the message names the key and the value.
TEST(TissueConfig, ValidationNamesTheKey) {
  EXPECT_NO_THROW(Validate({}));
  const auto message = [](const std::function<void(TissueConfig&)>& spoil) {
    TissueConfig config;
    spoil(config);
    try {
      Validate(config);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string("(accepted)");
  };
  EXPECT_THAT(message([](auto& c) { c.oxygenation_dermis = 1.5; }), HasSubstr("oxygenation_dermis is 1.5"));
  EXPECT_THAT(message([](auto& c) { c.epidermis_thickness_mm = 0.0; }),
              HasSubstr("epidermis_thickness_mm is 0"));
  EXPECT_THAT(message([](auto& c) { c.n_epidermis = 0.9; }), HasSubstr("n_epidermis is 0.9"));
  EXPECT_THAT(message([](auto& c) { c.junction_absorbance = -0.1; }), HasSubstr("junction_absorbance"));
  EXPECT_THAT(message([](auto& c) { c.scattering_amplitude = std::nan(""); }),
              HasSubstr("scattering_amplitude"));
  EXPECT_THAT(message([](auto& c) { c.anisotropy = 1.0; }), HasSubstr("anisotropy is 1"));
}

// What the environment names comes first; a folder without spectra is refused with the variable's name.
TEST(ConfigDirectory, FollowsTheEnvironment) {
  const auto found = ConfigDirectory();
  EXPECT_TRUE(std::filesystem::exists(found / "spectra" / "hemoglobin_prahl_1998.csv"));
  setenv("DERMAP_CONFIG_DIR", "/nonexistent", 1);
  EXPECT_THROW(ConfigDirectory(), InputError);
  setenv("DERMAP_CONFIG_DIR", found.c_str(), 1);
  EXPECT_EQ(ConfigDirectory(), found);
  unsetenv("DERMAP_CONFIG_DIR");
}

}  // namespace
}  // namespace dermap
