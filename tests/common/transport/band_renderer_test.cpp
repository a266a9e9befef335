// SPDX-License-Identifier: Apache-2.0
// One band: where the junction's absorber goes, and what a filter's width does.
#include "common/transport/band_renderer.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/common/transport/scenes.h"

namespace dermap {
namespace {

const Band kBands[] = {{450.0, 0.0}, {560.0, 0.0}, {650.0, 0.0}};

// A tattoo under the epidermis: P = 0.0175 everywhere is the default; more of it darkens the place, and
// planes of two bands darken their own band only. For uniform P and wide light the closed form.
TEST(BandRenderer, PutsTheJunctionAbsorberWhereThePlanesSay) {
  const ForwardModel model = Model(kBands, Conditions(32, Illumination::kUniform));
  ParameterMaps maps(32, 32, AverageSkin());
  const std::vector<PlaneF> plain = model.Render(maps);
  maps.junction_absorbance = {PlaneF(32, 32, 0.0175f)};
  EXPECT_LT(Compare(model.Render(maps)[1], plain[1]).relative_max, 1e-6);
  maps.junction_absorbance = {PlaneF(32, 32, 0.0175f), PlaneF(32, 32, 0.0175f), PlaneF(32, 32, 0.8f)};
  const std::vector<PlaneF> inked = model.Render(maps);
  EXPECT_LT(Compare(inked[0], plain[0]).relative_max, 1e-6);
  EXPECT_LT(Compare(inked[1], plain[1]).relative_max, 1e-6);
  EXPECT_NEAR(inked[2](16, 16), model.LocalReflectance(2, AverageSkin(), 0.8), 1e-5);
  EXPECT_LT(inked[2](16, 16), 0.8f * plain[2](16, 16));
}

// The trapezoid rule over the filter's Gaussian with full tables at every 2 nm, the knots of the tabulated
// spectra, by definition of a band's reflectance; on the steep flanks of blood's bands. 2e-3: the extinction
// tables have kinks (the worst at 600 nm) that no Gauss rule sees; elsewhere five nodes are within 1e-3, and
// the width itself weighs 1e-2.
TEST(BandRenderer, LocalReflectanceIntegratesTheFilter) {
  const Band bands[] = {{578.0, 10.0}, {600.0, 10.0}};
  const ForwardModel model = Model(bands, Conditions(32, Illumination::kUniform));
  ParameterVector skin = AverageSkin();
  skin[static_cast<int>(Parameter::kC_m)] = 0.02;
  for (int band = 0; band < 2; ++band) {
    const double sigma_nm = 10.0 / (2.0 * std::sqrt(2.0 * std::log(2.0)));
    double sum = 0.0, weights = 0.0;
    for (int offset_nm = -16; offset_nm <= 16; offset_nm += 2) {
      const double wavelength_nm = bands[band].wavelength_nm + offset_nm;
      const double weight = std::exp(-0.5 * std::pow(offset_nm / sigma_nm, 2));
      const Absorbers absorbers = TestChromophores().At(wavelength_nm, TissueConfig{});
      sum += weight * TestTables(wavelength_nm)
                          .TotalReflectance(absorbers.MuAEpidermis(skin), absorbers.MuADermis(skin), 0.0175);
      weights += weight;
    }
    const double expected = sum / weights;
    EXPECT_NEAR(model.LocalReflectance(band, skin, 0.0175), expected, 2e-3 * expected);
    const Absorbers center = TestChromophores().At(bands[band].wavelength_nm, TissueConfig{});
    const double centre_only =
        TestTables(bands[band].wavelength_nm)
            .TotalReflectance(center.MuAEpidermis(skin), center.MuADermis(skin), 0.0175);
    EXPECT_GT(std::abs(centre_only / expected - 1.0), 3e-3) << "the width hardly matters here";
  }
}

// The shortcut (one render and a local ratio) against a render at every wavelength of the filter, on the
// flanks of blood's bands, 10 nm wide, heterogeneous skin behind a window: within 2e-3 rms.
TEST(BandRenderer, WidthShortcutIsCloseToTheFullBand) {
  const Band bands[] = {{575.0, 10.0}, {590.0, 10.0}, {600.0, 10.0}};
  ForwardOptions full;
  full.full_band_integration = true;
  const ImagingConditions conditions = Conditions(64, Illumination::kWindow);
  const ParameterMaps maps = FreckledSkin(64, 6);
  const std::vector<PlaneF> exact = Model(bands, conditions, full).Render(maps);
  const std::vector<PlaneF> shortcut = Model(bands, conditions).Render(maps);
  for (int band = 0; band < 3; ++band) {
    const Difference difference = Compare(shortcut[band], exact[band]);
    RecordProperty("relative_rms_" + std::to_string(band), std::to_string(difference.relative_rms));
    EXPECT_LT(difference.relative_rms, 2e-3) << bands[band].wavelength_nm;
    EXPECT_LT(difference.relative_max, 5e-3) << bands[band].wavelength_nm;
  }
}

}  // namespace
}  // namespace dermap
