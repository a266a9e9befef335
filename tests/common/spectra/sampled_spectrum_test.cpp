// SPDX-License-Identifier: Apache-2.0
// Sampled spectra: interpolation, and what the CSV reader takes and refuses.
#include "common/spectra/sampled_spectrum.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>

#include "common/core/error.h"

namespace dermap {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

// A file in the temporary folder that vanishes with the test.
class TemporaryCsv {
 public:
  explicit TemporaryCsv(const std::string& contents)
      : path_(testing::TempDir() + "dermap_spectrum_" + std::to_string(getpid()) + ".csv") {
    std::ofstream(path_) << contents;
  }
  ~TemporaryCsv() { std::filesystem::remove(path_); }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

std::string MessageOf(const std::function<void()>& call) {
  try {
    call();
  } catch (const InputError& error) {
    return error.what();
  }
  return "(no InputError)";
}

// By hand: halfway from 10 to 20, a quarter from 20 to 40, and the samples themselves.
TEST(SampledSpectrum, IsLinearBetweenSamples) {
  const SampledSpectrum spectrum({400.0, 410.0, 430.0}, {10.0, 20.0, 40.0});
  EXPECT_DOUBLE_EQ(spectrum.At(405.0), 15.0);
  EXPECT_DOUBLE_EQ(spectrum.At(415.0), 25.0);
  EXPECT_DOUBLE_EQ(spectrum.At(400.0), 10.0);
  EXPECT_DOUBLE_EQ(spectrum.At(410.0), 20.0);
  EXPECT_DOUBLE_EQ(spectrum.At(430.0), 40.0);
}

// The claim of the header: extrapolation is refused, and so is a wavelength that is no number.
TEST(SampledSpectrum, RefusesToExtrapolate) {
  const SampledSpectrum spectrum({400.0, 410.0}, {1.0, 2.0});
  EXPECT_THROW(spectrum.At(399.9), InputError);
  EXPECT_THROW(spectrum.At(410.1), InputError);
  EXPECT_THROW(spectrum.At(std::nan("")), InputError);
  EXPECT_THAT(MessageOf([&] { spectrum.At(500.0); }), HasSubstr("400 to 410 nm was asked for 500 nm"));
  EXPECT_THROW(SampledSpectrum().At(500.0), InputError);
}

// The claim of the header: strictly ascending, as many wavelengths as values.
TEST(SampledSpectrum, RefusesSamplesOutOfOrder) {
  EXPECT_THROW(SampledSpectrum({400.0, 400.0}, {1.0, 2.0}), InputError);
  EXPECT_THROW(SampledSpectrum({410.0, 400.0}, {1.0, 2.0}), InputError);
  EXPECT_THROW(SampledSpectrum({400.0, 410.0}, {1.0}), InputError);
  EXPECT_THROW(SampledSpectrum({400.0}, {1.0}), InputError);
}

// The numbers written into the file by this test.
TEST(ReadSpectrumCsv, ReadsOneColumnAndSkipsComments) {
  const TemporaryCsv csv("# quantity: a\r\n# unit: 1\n\nwavelength_nm, a ,b\r\n400,1,-2e-3\n401.5,3, 4\r\n");
  const auto spectrum = ReadSpectrumCsv(csv.path(), "b");
  EXPECT_THAT(spectrum.wavelengths_nm(), ElementsAre(400.0, 401.5));
  EXPECT_THAT(spectrum.values(), ElementsAre(-2e-3, 4.0));
}

// House rule: one clear sentence that names file, line, what was found and what was expected.
TEST(ReadSpectrumCsv, NamesFileAndLineOfWhatIsWrong) {
  const auto message = [](const std::string& contents, const std::string& column) {
    const TemporaryCsv csv(contents);
    return MessageOf([&] { ReadSpectrumCsv(csv.path(), column); });
  };
  EXPECT_THAT(message("wavelength_nm,a\n400,1\n401,abc\n", "a"), HasSubstr("line 3: found 'abc'"));
  EXPECT_THAT(message("wavelength_nm,a\n400,1\n401,nan\n", "a"), HasSubstr("line 3: found 'nan'"));
  EXPECT_THAT(message("wavelength_nm,a\n400,1,7\n", "a"), HasSubstr("line 2: found 3 fields"));
  EXPECT_THAT(message("nm,a\n400,1\n", "a"), HasSubstr("'wavelength_nm' is expected"));
  EXPECT_THAT(message("wavelength_nm,a,b\n400,1,2\n", "c"), HasSubstr("wavelength_nm, a, b"));
  EXPECT_THAT(message("wavelength_nm,a\n401,1\n400,1\n", "a"), HasSubstr("must ascend"));
  EXPECT_THAT(message("", "a"), HasSubstr("two samples"));
  EXPECT_THAT(MessageOf([] { ReadSpectrumCsv("/nonexistent/x.csv", "a"); }), HasSubstr("/nonexistent/x.csv"));
}

// CIE 015: ybar peaks at 1 near 555 nm, and light of equal energy is white, x = y = 1/3.
TEST(ShippedSpectra, ColourMatchingFunctionsMakeEqualEnergyWhite) {
  double sums[3] = {0.0, 0.0, 0.0};
  const char* columns[3] = {"xbar", "ybar", "zbar"};
  for (int i = 0; i < 3; ++i) {
    const auto cmf = ReadSpectrumCsv("config/spectra/cie1931_2deg.csv", columns[i]);
    for (const double value : cmf.values()) sums[i] += value;
  }
  EXPECT_NEAR(sums[0] / (sums[0] + sums[1] + sums[2]), 1.0 / 3.0, 1e-4);
  EXPECT_NEAR(sums[1] / (sums[0] + sums[1] + sums[2]), 1.0 / 3.0, 1e-4);
  EXPECT_NEAR(ReadSpectrumCsv("config/spectra/cie1931_2deg.csv", "ybar").At(555.0), 1.0, 1e-3);
}

// CIE 015: white point of D65 x = 0.3127, y = 0.3290; of A 0.4476, 0.4074; of D50 0.3457, 0.3585.
TEST(ShippedSpectra, IlluminantsHaveTheirPublishedWhitePoints) {
  struct WhitePoint {
    const char* name;
    double x, y;
  };
  for (const auto& white :
       {WhitePoint{"D65", 0.3127, 0.3290}, {"A", 0.4476, 0.4074}, {"D50", 0.3457, 0.3585}}) {
    const auto light = ReadSpectrumCsv("config/spectra/cie_illuminants.csv", white.name);
    double xyz[3] = {0.0, 0.0, 0.0};
    const char* columns[3] = {"xbar", "ybar", "zbar"};
    for (int i = 0; i < 3; ++i) {
      const auto cmf = ReadSpectrumCsv("config/spectra/cie1931_2deg.csv", columns[i]);
      for (double nm = 360.0; nm <= 830.0; nm += 1.0) xyz[i] += cmf.At(nm) * light.At(nm);
    }
    EXPECT_NEAR(xyz[0] / (xyz[0] + xyz[1] + xyz[2]), white.x, 1e-4) << white.name;
    EXPECT_NEAR(xyz[1] / (xyz[0] + xyz[1] + xyz[2]), white.y, 1e-4) << white.name;
  }
}

// Labsphere: a 99 % panel reflects between 0.97 and 1 from 350 to 1000 nm.
TEST(ShippedSpectra, SpectralonIsNearlyWhite) {
  const auto panel = ReadSpectrumCsv("config/spectra/spectralon_99_labsphere.csv", "reflectance");
  EXPECT_EQ(panel.first_nm(), 350.0);
  EXPECT_EQ(panel.last_nm(), 1000.0);
  for (const double value : panel.values()) EXPECT_TRUE(value > 0.97 && value < 1.0) << value;
}

}  // namespace
}  // namespace dermap
