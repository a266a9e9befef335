// SPDX-License-Identifier: Apache-2.0
// The folder that a fit of spectra leaves.
#include "fit/spectra/write_spectra.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <sstream>

#include "common/core/error.h"
#include "tests/common/files/temporary_folder.h"
#include "tests/fit/report/html_check.h"
#include "tests/fit/spectra/made_spectra.h"

namespace dermap {
namespace {

using enum SkinParameter;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::UnorderedElementsAre;

const SpectraFit& TwoSpectra() {
  static const SpectraFit fit = [] {
    MeasuredSpectra spectra;
    spectra.wavelengths_nm = TestWavelengths();
    spectra.label_names = {"record", "site, side"};
    spectra.rows = {{{"1", "<b>arm</b>"}, MadeSpectrum(SkinWith({{kC_m, 0.03}}), TestWavelengths()), {}},
                    {{"2", "back"}, MadeSpectrum(SkinWith({{kC_m, 0.12}}), TestWavelengths()), {}}};
    return FitSpectra(spectra,
                      {.instrument = {.aperture = {}, .fwhm_nm = 0.0},
                       .noise = {},
                       .tissue = MeasuredTissue(),
                       .model = "core"},
                      TestChromophores());
  }();
  return fit;
}

// Source: docs/formats.md; the skins are the ones that the spectra were made from.
TEST(WriteSpectra, LeavesATableWithEveryParameterAndItsSigma) {
  std::istringstream csv(SpectraCsv(TwoSpectra()));
  std::string header, first, second, rest;
  std::getline(csv, header);
  std::getline(csv, first);
  std::getline(csv, second);
  EXPECT_FALSE(std::getline(csv, rest));
  EXPECT_THAT(header,
              ::testing::StartsWith("record,\"site, side\",model,rms,bic,converged,at_bound,not_identifiable,"
                                    "C_m,sigma_C_m,beta_m,sigma_beta_m,"));
  EXPECT_THAT(header, ::testing::EndsWith(",surface_reflectance,sigma_surface_reflectance"));
  EXPECT_EQ(std::count(header.begin(), header.end(), ',') - 1, std::count(second.begin(), second.end(), ','));
  EXPECT_THAT(first, HasSubstr(",core,"));
  EXPECT_NEAR(TwoSpectra().fits[1].best().skin[0], 0.12, 0.003);
  EXPECT_TRUE(TwoSpectra().Converged());
}

// Source: docs/formats.md.
TEST(WriteSpectra, LeavesJsonWithSpectraAndCandidates) {
  const nlohmann::ordered_json json = SpectraJson(TwoSpectra(), true);
  EXPECT_EQ(json["count"], 2);
  EXPECT_LT(json["median_rms"].get<double>(), 5e-4);
  EXPECT_EQ(json["models"].size(), 1u);
  EXPECT_EQ(json["models"][0]["chosen"], 2);
  EXPECT_EQ(json["spectra"][1]["labels"]["site, side"], "back");
  EXPECT_EQ(json["spectra"][1]["predicted"].size(), 33u);
  EXPECT_EQ(json["spectra"][0]["candidates"][0]["free"].size(), 5u);
  EXPECT_FALSE(SpectraJson(TwoSpectra(), false).contains("spectra"));
}

// Source: a page must open without a network, and labels are text, not markup.
TEST(WriteSpectra, LeavesAPageThatStandsAlone) {
  const TemporaryFolder folder;
  WriteSpectra(folder.path() / "out", TwoSpectra(), "skin & more.csv");
  EXPECT_THAT(folder.Names(),
              UnorderedElementsAre("out", "out/spectra.csv", "out/spectra.json", "out/report.html"));
  const std::string html = Slurp(folder / "out/report.html");
  EXPECT_THAT(html, HasSubstr("skin &amp; more.csv"));
  EXPECT_THAT(html, HasSubstr("&lt;b&gt;arm&lt;/b&gt;"));
  EXPECT_THAT(html, Not(HasSubstr("<b>arm")));
  EXPECT_THAT(NestingFaults(html), IsEmpty());
  EXPECT_THAT(OutsideReferences(html), IsEmpty());
  EXPECT_THAT(html, HasSubstr("<svg"));
}

// Source: SkinModels; a name that is not there is refused with the list of those that are.
TEST(SkinModels, FreeAtMostSevenAndAreFoundByName) {
  for (const SkinModel& model : SkinModels(MeasuredTissue())) {
    EXPECT_LE(model.free.size(), 7u) << model.name;
    EXPECT_EQ(SkinModelFromName(model.name, {}).free, model.free);
    for (int i = 0; i < kSkinParameterCount; ++i) {
      EXPECT_GE(model.fixed[i], kSkinParameters[i].lower);
      EXPECT_LE(model.fixed[i], kSkinParameters[i].upper);
    }
  }
  EXPECT_THAT(SentenceOf<InputError>([] { SkinModelFromName("veins", {}); }), HasSubstr("'veins'"));
}

}  // namespace
}  // namespace dermap
