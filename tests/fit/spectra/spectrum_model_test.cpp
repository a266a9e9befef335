// SPDX-License-Identifier: Apache-2.0
// The spectrum of known skin, against adding-doubling and against what each part must do by itself.
#include "fit/spectra/spectrum_model.h"

#include <gtest/gtest.h>

#include <cmath>

#include "fit/spectra/fit_spectra.h"
#include "tests/fit/spectra/made_spectra.h"

namespace dermap {
namespace {

using enum SkinParameter;

// Source: adding-doubling with g = 0.8, 1e-3 of R: light, medium and dark skin, thin and thick epidermis,
// blood in vessels, every parameter away from its mean once.
TEST(SpectrumModel, AgreesWithAddingDoubling) {
  const std::vector<SkinVector> skins{
      SkinWith({{kC_m, 0.02}, {kC_hd, 0.02}}),
      SkinWith({{kC_m, 0.3}, {kBeta_m, 1.0}, {kThickness, 0.1}, {kAmplitude, 1.6}, {kOxygenation, 0.4}}),
      SkinWith({{kC_m, 0.06}, {kC_he, 0.01}, {kC_bc, 0.02}, {kC_hd, 0.06}, {kVesselRadius, 0.03}}),
      SkinWith({{kC_m, 0.05}, {kBaseline, 1.7}, {kSlope, -0.7}, {kSurface, 0.02}, {kThickness, 0.25}})};
  for (const SkinVector& skin : skins) {
    const std::vector<double> judge = MadeSpectrum(skin, TestWavelengths());
    std::vector<double> predicted(judge.size());
    MonochromaticModel().Predict(skin, predicted.data());
    for (std::size_t i = 0; i < judge.size(); ++i) {
      EXPECT_NEAR(predicted[i] / judge[i], 1.0, 1e-3) << TestWavelengths()[i] << " nm, C_m " << skin[0];
    }
  }
}

// Source: Duysens' flattening: thin vessels change nothing, thick ones are black discs whose absorption no
// longer depends on the blood; (1 - exp(-1)) / 1 at 2 mu_a r = 1. The series joins the closed form.
TEST(PackedShare, GoesFromOneToOneOverDepth) {
  EXPECT_EQ(PackedShare(20.0, 0.0), 1.0);
  EXPECT_NEAR(PackedShare(20.0, 0.025), 1.0 - std::exp(-1.0), 1e-15);
  EXPECT_NEAR(PackedShare(200.0, 1.0), 1.0 / 400.0, 1e-15);
  EXPECT_NEAR(PackedShare(0.999e-3, 0.5), PackedShare(1.001e-3, 0.5), 2e-6);
}

// Source: Fresnel at n = 1.4: (0.4 / 2.4)^2.
TEST(SpectrumModel, AddsTheMirrorReflectionWhereTheInstrumentSawIt) {
  const std::vector<double> nm{500.0, 600.0};
  const SpectrumModel with({.aperture = {}, .fwhm_nm = 0.0, .specular_included = true}, MeasuredTissue(),
                           TestChromophores(), nm, {});
  const SkinVector skin = SkinWith({});
  std::array<double, 2> included{};
  with.Predict(skin, included.data());
  std::vector<double> excluded(33);
  MonochromaticModel().Predict(skin, excluded.data());
  EXPECT_NEAR(included[0] - excluded[10], 1.0 / 36.0, 1e-9);
  EXPECT_NEAR(included[1] - excluded[20], 1.0 / 36.0, 1e-9);
}

// Source: reciprocity: what leaves at 30 degrees is what would enter there: (1 - F(30)) / (1 - diffuse F) of
// n = 1.4, by hand (0.97095 / 0.92319).
TEST(SpectrumModel, KnowsAFactorSeenAtThirtyDegrees) {
  const std::vector<double> nm{500.0, 600.0};
  const SpectrumModel seen({.aperture = {}, .fwhm_nm = 0.0, .geometry = Geometry::kFactor0_30},
                           MeasuredTissue(), TestChromophores(), nm, {});
  std::array<double, 2> at_30{};
  seen.Predict(SkinWith({}), at_30.data());
  std::vector<double> all(33);
  MonochromaticModel().Predict(SkinWith({}), all.data());
  EXPECT_NEAR(at_30[0] / all[10], at_30[1] / all[20], 1e-9);
  EXPECT_NEAR(at_30[0] / all[10], 0.97095 / 0.92319, 1e-4);
}

// Source: a triangle of full width 10 nm at half maximum holds the mean of R over it; here by 2000
// monochromatic samples. Beside the oxyhemoglobin peak at 577 nm that is 0.004 more than R at its middle.
TEST(SpectrumModel, AveragesOverTheWidthOfABand) {
  const SpectrumModel wide({.aperture = {}, .fwhm_nm = 10.0}, MeasuredTissue(), TestChromophores(), {577.0},
                           {});
  std::vector<double> fine;
  for (int i = 0; i <= 80; ++i) fine.push_back(567.0 + 0.25 * i);
  const SpectrumModel narrow({.aperture = {}, .fwhm_nm = 0.0}, MeasuredTissue(), TestChromophores(), fine,
                             {});
  const SkinVector skin = SkinWith({{kC_m, 0.01}, {kC_hd, 0.03}, {kOxygenation, 1.0}});
  double band = 0.0, mean = 0.0, weights = 0.0;
  wide.Predict(skin, &band);
  std::vector<double> at(fine.size());
  narrow.Predict(skin, at.data());
  for (std::size_t i = 0; i < fine.size(); ++i) {
    const double weight = 1.0 - std::abs(fine[i] - 577.0) / 10.0;
    mean += weight * at[i];
    weights += weight;
  }
  EXPECT_NEAR(band, mean / weights, 3e-4);
  EXPECT_GT(band, at[40] + 0.001);
}

// Source: the smaller the aperture, the more light leaves beside it; red light, which goes far, most of all.
TEST(SpectrumModel, LosesRedLightBesideAnAperture) {
  const SpectrumModel narrow({.aperture = {1.5, 3.0}, .fwhm_nm = 0.0}, MeasuredTissue(), TestChromophores(),
                             TestWavelengths(), {});
  const SkinVector skin = SkinWith({{kC_m, 0.03}, {kC_hd, 0.01}});
  std::vector<double> small(33), wide(33);
  narrow.Predict(skin, small.data());
  MonochromaticModel().Predict(skin, wide.data());
  EXPECT_NEAR(small[0] / wide[0], 1.0, 0.01);
  EXPECT_LT(small[32] / wide[32], 0.96);
  EXPECT_GT(small[32] / wide[32], 0.75);
}

}  // namespace
}  // namespace dermap
