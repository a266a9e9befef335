// SPDX-License-Identifier: Apache-2.0
#include "common/files/maps.h"

#include <gmock/gmock.h>

#include <limits>

#include "tests/common/files/exr_builder.h"
#include "tests/common/files/temporary_folder.h"

namespace dermap {
namespace {

using testing::AllOf;
using testing::HasSubstr;

MapsFile MakeMaps() {
  MapsFile file;
  file.maps = ParameterMaps(6, 4, {0.06, 0.62, 0.005, 0.01, 0.03});
  file.maps[Parameter::kC_m](5, 3) = 0.25f;
  file.maps[Parameter::kC_hd](0, 1) = 0.0625f;
  file.bands = {{450.1, 9.7}, {600.0, 10.0}};
  file.pixel_size_mm = 0.03;
  file.geometry = Geometry::kFactor0_30;
  file.tape = Tape::kBlack;
  return file;
}

class MapsTest : public testing::Test {
 protected:
  MapsFile RoundTrip(const MapsFile& file) {
    WriteMaps(folder_ / "maps.exr", file);
    return ReadMaps(folder_ / "maps.exr");
  }
  // The five channels of [D08 table 1], by hand.
  static ExrBuilder FiveChannels(double c_m = 0.25) {
    ExrBuilder builder(4, 3);
    for (const char* name : {"beta_m", "C_he", "C_bc", "C_hd"}) {
      builder.Channel(name, ExrType::kFloat, [](int, int) { return 0.03125; });
    }
    builder.Channel("C_m", ExrType::kFloat, [=](int x, int y) { return x == 2 && y == 1 ? c_m : 0.125; });
    return builder;
  }
  std::string SentenceFor(const ExrBuilder& builder) {
    const auto path = folder_.Write("some.exr", builder.Build());
    return SentenceOf<InputError>([&] { ReadMaps(path); });
  }
  TemporaryFolder folder_;
};

// What was written comes back; 450.1 and 9.7 are no float32 and must come back as decimals all the same.
TEST_F(MapsTest, ComeBackAsWritten) {
  const MapsFile read = RoundTrip(MakeMaps());
  EXPECT_EQ(read.maps.width(), 6);
  EXPECT_EQ(read.maps.height(), 4);
  EXPECT_EQ(read.maps[Parameter::kC_m](5, 3), 0.25f);
  EXPECT_EQ(read.maps[Parameter::kC_m](4, 3), 0.06f);
  EXPECT_EQ(read.maps[Parameter::kBeta_m](0, 0), 0.62f);
  EXPECT_EQ(read.maps[Parameter::kC_he](0, 0), 0.005f);
  EXPECT_EQ(read.maps[Parameter::kC_bc](0, 0), 0.01f);
  EXPECT_EQ(read.maps[Parameter::kC_hd](0, 1), 0.0625f);
  EXPECT_TRUE(read.maps.junction_absorbance.empty());
  ASSERT_EQ(read.bands.size(), 2u);
  EXPECT_EQ(read.bands[0].wavelength_nm, 450.1);
  EXPECT_EQ(read.bands[0].fwhm_nm, 9.7);
  EXPECT_EQ(read.pixel_size_mm, 0.03);
  EXPECT_EQ(read.geometry, Geometry::kFactor0_30);
  EXPECT_EQ(read.tape, Tape::kBlack);
  EXPECT_EQ(read.illumination, Illumination::kWindow);
}

// DESIGN: junction_absorbance is one gray channel, or one a band for inks, in the order of the bands.
TEST_F(MapsTest, KeepTheJunctionGrayOrByBand) {
  MapsFile file = MakeMaps();
  file.maps.junction_absorbance = {PlaneF(6, 4, 0.5f)};
  EXPECT_EQ(RoundTrip(file).maps.junction_absorbance.at(0)(1, 1), 0.5f);
  file.bands = {{600.0, 10.0}, {1000.0, 10.0}};  // as text, 1000 comes first
  file.maps.junction_absorbance = {PlaneF(6, 4, 0.5f), PlaneF(6, 4, 0.75f)};
  const MapsFile read = RoundTrip(file);
  ASSERT_EQ(read.maps.junction_absorbance.size(), 2u);
  EXPECT_EQ(read.maps.junction_absorbance[0](0, 0), 0.5f);
  EXPECT_EQ(read.maps.junction_absorbance[1](0, 0), 0.75f);
}

// Maps by hand, without an attribute: DESIGN's defaults and no bands.
TEST_F(MapsTest, TakeDefaultsWhereTheFileSaysNothing) {
  const MapsFile read = ReadMaps(folder_.Write("some.exr", FiveChannels().Build()));
  EXPECT_EQ(read.maps[Parameter::kC_m](2, 1), 0.25f);
  EXPECT_TRUE(read.bands.empty());
  EXPECT_FALSE(read.pixel_size_mm);
  EXPECT_EQ(read.geometry, Geometry::kHemispherical);
}

// Each mistake in one sentence with file, channel and pixel.
TEST_F(MapsTest, RejectWhatCannotBe) {
  EXPECT_THAT(SentenceFor(FiveChannels(NAN)),
              AllOf(HasSubstr("some.exr"), HasSubstr("C_m is nan at pixel (2, 1)")));
  EXPECT_THAT(SentenceFor(FiveChannels(INFINITY)), HasSubstr("C_m is inf"));
  EXPECT_THAT(SentenceFor(FiveChannels(-0.5)), HasSubstr("C_m is -0.5 at pixel (2, 1)"));
  EXPECT_THAT(SentenceFor(ExrBuilder(4, 3).Channel("C_m", ExrType::kFloat, [](int, int) { return 0.5; })),
              AllOf(HasSubstr("no channel 'beta_m'"), HasSubstr("its channels: C_m")));
  const auto half = [](int, int) { return 0.5; };
  EXPECT_THAT(SentenceFor(FiveChannels().Channel("junction_absorbance.450,000000nm", ExrType::kFloat, half)),
              HasSubstr("do not agree"));
  EXPECT_THAT(SentenceFor(FiveChannels().Channel("junction_absorbance.red", ExrType::kFloat, half)),
              HasSubstr("names no wavelength"));
  EXPECT_THAT(SentenceFor(FiveChannels().Floats("dermap:wavelengthsNm", {600, 450})), HasSubstr("ascending"));
  EXPECT_THAT(SentenceFor(FiveChannels().Floats("dermap:wavelengthsNm", {450, 2000})), HasSubstr("2000 nm"));
  EXPECT_THAT(
      SentenceFor(FiveChannels().Floats("dermap:wavelengthsNm", {450}).Floats("dermap:fwhmNm", {1, 2})),
      HasSubstr("has 2 values; expected 1"));
}

// Any planes by name; OpenEXR keeps channels in the order of their names.
TEST_F(MapsTest, PlanesKeepNamesAndValues) {
  WritePlanes(folder_ / "flags.exr", {{"flags", PlaneF(3, 2, 21.0f)}, {"chi2", PlaneF(3, 2, 1.5f)}}, 0.5);
  const NamedPlanes read = ReadPlanes(folder_ / "flags.exr");
  ASSERT_EQ(read.size(), 2u);
  EXPECT_EQ(read[0].first, "chi2");
  EXPECT_EQ(read[1].first, "flags");
  EXPECT_EQ(read[1].second(2, 1), 21.0f);
}

}  // namespace
}  // namespace dermap
