// SPDX-License-Identifier: Apache-2.0
// Tables of spectra as instruments and people write them, and what is refused in one sentence.
#include "fit/spectra/spectra_table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "common/core/error.h"
#include "tests/common/files/temporary_folder.h"

namespace dermap {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

class Spectra : public ::testing::Test {
 protected:
  MeasuredSpectra Read(const std::string& text, const SpectraFormat& format = {}) {
    return ReadSpectra(folder_.Write("spectra.csv", text), format);
  }
  std::string Refusal(const std::string& text, const SpectraFormat& format = {}) {
    return SentenceOf<InputError>([&] { Read(text, format); });
  }
  TemporaryFolder folder_;
};

const std::string kHeader = "R400,R440,R480,R520,R560,R600,R640,R680";
const std::string kValues = "0.1,0.12,0.15,0.2,0.2,0.3,0.35,0.4";

// Source: the header of the documented layout `rows`; other columns are labels and come along.
TEST_F(Spectra, TakesARowForASpectrum) {
  const MeasuredSpectra spectra =
      Read("# CM-2600d\nrecord,site,R390," + kHeader + ",R740\n7,cheek,9e-2," + kValues + ",0.5\n");
  EXPECT_THAT(spectra.label_names, ElementsAre("record", "site"));
  ASSERT_EQ(spectra.rows.size(), 1u);
  EXPECT_THAT(spectra.rows[0].labels, ElementsAre("7", "cheek"));
  EXPECT_THAT(spectra.wavelengths_nm,
              ElementsAre(400, 440, 480, 520, 560, 600, 640, 680));  // 390, 740: out of range
  EXPECT_THAT(spectra.rows[0].reflectance, ElementsAre(0.1, 0.12, 0.15, 0.2, 0.2, 0.3, 0.35, 0.4));
}

// Source: names that instruments give to wavelengths.
TEST_F(Spectra, KnowsManyNamesOfAWavelength) {
  const MeasuredSpectra spectra =
      Read("400,r_440,480 nm,520nm,Reflectance 560,\"R(600)\",WL640,lambda_680.5\n" + kValues + "\n" +
           kValues + "\n");
  EXPECT_THAT(spectra.wavelengths_nm, ElementsAre(400, 440, 480, 520, 560, 600, 640, 680.5));
  EXPECT_THAT(spectra.label_names, ElementsAre("spectrum"));
  EXPECT_THAT(spectra.rows[1].labels, ElementsAre("2"));
}

// Source: the documented layout `columns`, told by the first name or by hand; per cent by hand.
TEST_F(Spectra, TakesAColumnForASpectrum) {
  std::string text = "wavelength_nm,arm,cheek\n";
  for (int i = 0; i < 8; ++i) text += std::to_string(400 + 40 * i) + ",20," + std::to_string(10 + i) + "\n";
  const MeasuredSpectra spectra = Read(text, {.per_cent = true});
  ASSERT_EQ(spectra.rows.size(), 2u);
  EXPECT_THAT(spectra.rows[1].labels, ElementsAre("cheek"));
  EXPECT_NEAR(spectra.rows[1].reflectance[7], 0.17, 1e-12);
  text.replace(0, 13, "lambda/nm    ");
  EXPECT_EQ(Read(text, {.layout = "columns", .per_cent = true}).wavelengths_nm.size(), 8u);
}

// Source: the demand: missing cells, NaN, per cent, wavelengths that do not ascend, text.
TEST_F(Spectra, RefusesWhatIsNoReflectance) {
  const auto row = [&](const std::string& last) {
    return Refusal("id," + kHeader + "\na," + kValues + "\nb,0.1,0.12,0.15,0.2,0.2,0.3,0.35," + last + "\n");
  };
  EXPECT_THAT(row(""), HasSubstr("spectra.csv line 3: the reflectance at R680 is missing"));
  EXPECT_THAT(row("nan"), HasSubstr("line 3: the reflectance at R680 is 'nan'"));
  EXPECT_THAT(row("n/a"), HasSubstr("'n/a'; expected a finite number"));
  EXPECT_THAT(row("40.1"), HasSubstr("look like per cent, which --percent reads"));
  EXPECT_THAT(row("-0.3"), HasSubstr("is -0.3; expected a fraction from 0"));
  EXPECT_THAT(row("0.4,0.5"), HasSubstr("line 3: found 10 fields, expected 9"));
}

// Source: likewise, for the head of the table.
TEST_F(Spectra, RefusesATableWithoutWavelengths) {
  EXPECT_THAT(Refusal("id,first,second\na,0.1,0.2\n"),
              HasSubstr("no column is named by a wavelength, the first is 'id'"));
  EXPECT_THAT(Refusal("R400,R500,R450\n0.1,0.2,0.2\n"), HasSubstr("line 1: after 500 nm comes 450 nm"));
  EXPECT_THAT(Refusal("R400,R400\n0.1,0.2\n"), HasSubstr("after 400 nm comes 400 nm; expected ascending"));
  EXPECT_THAT(Refusal("R400,R500\n0.1,0.2\n"),
              HasSubstr("found 2 wavelengths from 400 to 720 nm; expected at least 8"));
  EXPECT_THAT(Refusal(kHeader + "\n"), HasSubstr("no rows"));
  EXPECT_THAT(Refusal("wavelength_nm\n400\n"), HasSubstr("no spectrum"));
  EXPECT_THAT(Refusal("wavelength_nm,a\n400,0.1\n390,0.1\n"), HasSubstr("line 3: after 400 nm comes 390 nm"));
  EXPECT_THAT(Refusal(kHeader + "\n" + kValues + "\n", {.layout = "diagonal"}),
              HasSubstr("auto, rows or columns"));
}

// Source: a stack is the same data as planes: one spectrum a valid pixel, its noise with it.
TEST_F(Spectra, TakesThePixelsOfAStack) {
  ReflectanceStack stack;
  for (int i = 0; i < 8; ++i) {
    stack.bands.push_back({400.0 + 40.0 * i, 10.0});
    stack.reflectance.emplace_back(2, 1, 0.1F * static_cast<float>(i));
    stack.sigma.emplace_back(2, 1, 0.01F);
  }
  stack.reflectance[3](1, 0) = std::nanf("");
  const MeasuredSpectra spectra = SpectraOfStack(stack, {}, "pixel.exr");
  ASSERT_EQ(spectra.rows.size(), 1u);
  EXPECT_THAT(spectra.rows[0].labels, ElementsAre("0", "0"));
  EXPECT_FLOAT_EQ(static_cast<float>(spectra.rows[0].reflectance[7]), 0.7F);
  EXPECT_EQ(spectra.rows[0].sigma.size(), 8u);
  stack.valid = PlaneF(2, 1, 0.0F);
  EXPECT_THAT(SentenceOf<InputError>([&] { SpectraOfStack(stack, {}, "pixel.exr"); }),
              HasSubstr("pixel.exr has no pixel"));
}

}  // namespace
}  // namespace dermap
