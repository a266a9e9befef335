// SPDX-License-Identifier: Apache-2.0
#include <OpenImageIO/imageio.h>
#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <random>

#include "common/files/stack.h"
#include "tests/common/files/exr_builder.h"
#include "tests/common/files/temporary_folder.h"

namespace dermap {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

// Every pixel of every plane differs, so that no swap of axes, bands or planes goes unseen.
PlaneF Ramp(int width, int height, float start) {
  PlaneF plane(width, height);
  float value = start;
  for (float& v : plane.values()) v = value += 1.0f / 1024.0f;
  return plane;
}

ReflectanceStack MakeStack() {
  ReflectanceStack stack;
  stack.bands = {{450.0, 10.0}, {532.25, 12.7}, {1000.0, 0.0}};
  for (int i = 0; i < 3; ++i) {
    stack.reflectance.push_back(Ramp(7, 5, 0.1f * static_cast<float>(i)));
    stack.sigma.push_back(Ramp(7, 5, 0.01f * static_cast<float>(i)));
  }
  stack.reflectance[1](6, 4) = kNan;
  stack.valid = PlaneF(7, 5, 1.0f);
  stack.valid(2, 3) = 0.0f;
  stack.pixel_size_mm = 0.1;
  stack.illumination = Illumination::kUniform;
  stack.tape = Tape::kBlack;
  stack.geometry = Geometry::kFactor0_30;
  stack.shared_error = 0.0;
  stack.noise_correlation_x = {0.4f, -0.05f};
  stack.noise_correlation_y = {0.25f};
  stack.notes["subject"] = "S01 \"é\"";
  return stack;
}

void ExpectSamePlane(const PlaneF& a, const PlaneF& b) {
  ASSERT_TRUE(a.SameShape(b));
  for (std::size_t i = 0; i < a.size(); ++i) {
    const float x = a.values()[i], y = b.values()[i];
    ASSERT_TRUE(x == y || (std::isnan(x) && std::isnan(y))) << "pixel " << i << ": " << x << " and " << y;
  }
}

class StackExrTest : public testing::Test {
 protected:
  ReflectanceStack Read(const std::string& bytes) {
    return ReadReflectanceStack(folder_.Write("some.exr", bytes));
  }
  std::string SentenceFor(const std::string& bytes) {
    return SentenceOf<InputError>([&] { Read(bytes); });
  }
  TemporaryFolder folder_;
};

double Gradient(int x, int y) {
  return (x + 2 * y) / 64.0;
}
ExrBuilder OneBand(int width = 4, int height = 3) {
  return ExrBuilder(width, height).Channel("T.450,000000nm", ExrType::kFloat, Gradient);
}

// The contract: what was written comes back, bit for bit.
TEST_F(StackExrTest, ComesBackAsWritten) {
  const ReflectanceStack written = MakeStack();
  WriteReflectanceStack(folder_ / "stack.exr", written);
  const ReflectanceStack read = ReadReflectanceStack(folder_ / "stack.exr");
  ASSERT_EQ(read.bands.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(read.bands[i].wavelength_nm, written.bands[i].wavelength_nm);
    EXPECT_EQ(read.bands[i].fwhm_nm, written.bands[i].fwhm_nm);
    ExpectSamePlane(read.reflectance[i], written.reflectance[i]);
    ExpectSamePlane(read.sigma[i], written.sigma[i]);
  }
  ExpectSamePlane(read.valid, written.valid);
  EXPECT_EQ(read.shared_error, 0.0);
  EXPECT_EQ(read.pixel_size_mm, 0.1);
  EXPECT_EQ(read.illumination, Illumination::kUniform);
  EXPECT_EQ(read.tape, Tape::kBlack);
  EXPECT_EQ(read.geometry, Geometry::kFactor0_30);
  EXPECT_EQ(read.noise_correlation_x, written.noise_correlation_x);
  EXPECT_EQ(read.noise_correlation_y, written.noise_correlation_y);
  EXPECT_EQ(read.notes, written.notes);
}

// Files of one content are one file: no time stamp, no order of insertion.
TEST_F(StackExrTest, IsTheSameFileEveryTime) {
  WriteReflectanceStack(folder_ / "a.exr", MakeStack());
  WriteReflectanceStack(folder_ / "b.exr", MakeStack());
  EXPECT_EQ(Slurp(folder_ / "a.exr"), Slurp(folder_ / "b.exr"));
}

// OpenImageIO as a second reader: names, attributes and pixels as DESIGN's contract has them.
TEST_F(StackExrTest, IsReadByAnotherProgram) {
  WriteReflectanceStack(folder_ / "stack.exr", MakeStack());
  const auto input = OIIO::ImageInput::open((folder_ / "stack.exr").string());
  ASSERT_TRUE(input) << OIIO::geterror();
  const OIIO::ImageSpec& spec = input->spec();
  EXPECT_EQ(spec.width, 7);
  EXPECT_EQ(spec.height, 5);
  EXPECT_EQ(spec.format, OIIO::TypeDesc::FLOAT);
  EXPECT_THAT(spec.channelnames,
              testing::UnorderedElementsAre("T.450,000000nm", "T.532,250000nm", "T.1000,000000nm",
                                            "sigma.450,000000nm", "sigma.532,250000nm", "sigma.1000,000000nm",
                                            "valid"));
  EXPECT_EQ(spec.get_string_attribute("spectralLayoutVersion"), "1.0");
  EXPECT_FLOAT_EQ(spec.get_float_attribute("dermap:pixelSizeMm"), 0.1f);
  EXPECT_EQ(spec.get_string_attribute("dermap:illumination"), "uniform");
  EXPECT_EQ(spec.get_string_attribute("dermap:tape"), "black");
  EXPECT_EQ(spec.get_string_attribute("dermap:geometry"), "0/30");
  std::vector<float> pixels(7u * 5u * 7u);
  ASSERT_TRUE(input->read_image(0, 0, 0, -1, OIIO::TypeDesc::FLOAT, pixels.data()));
  const auto channel = static_cast<std::size_t>(spec.channelindex("T.532,250000nm"));
  EXPECT_EQ(pixels[(3u * 7u + 2u) * 7u + channel], MakeStack().reflectance[1](2, 3));
}

// A file put together by hand after "OpenEXR File Layout": text order is not the order of wavelengths.
TEST_F(StackExrTest, SortsBandsByWavelength) {
  const ReflectanceStack stack =
      Read(ExrBuilder(4, 3)
               .Channel("T.1000,000000nm", ExrType::kFloat, [](int, int) { return 0.75; })
               .Channel("T.450,000000nm", ExrType::kFloat, Gradient)
               .Channel("T.0,6um", ExrType::kFloat, [](int, int) { return 0.5; })
               .Channel("R", ExrType::kFloat, [](int, int) { return 9.0; })
               .Channel("other.x", ExrType::kUint, [](int, int) { return 9.0; })
               .Text("spectralLayoutVersion", "1.0")
               .Floats("dermap:fwhmNm", {8, 9, 10})
               .Build());
  ASSERT_EQ(stack.bands.size(), 3u);
  EXPECT_NEAR(stack.bands[1].wavelength_nm, 600.0, 1e-9);
  EXPECT_EQ(stack.bands[2].wavelength_nm, 1000.0);
  EXPECT_EQ(stack.bands[0].fwhm_nm, 8.0);
  EXPECT_EQ(stack.reflectance[0](3, 2), 7.0f / 64.0f);
  EXPECT_EQ(stack.reflectance[0](1, 0), 1.0f / 64.0f);
  EXPECT_EQ(stack.reflectance[1](3, 2), 0.5f);
  EXPECT_EQ(stack.reflectance[2](0, 0), 0.75f);
  EXPECT_TRUE(stack.sigma.empty());
  EXPECT_TRUE(stack.valid.empty());
}

// DESIGN's table of defaults, for any stack from any rig; one band is enough.
TEST_F(StackExrTest, TakesDefaultsWhereTheFileSaysNothing) {
  const ReflectanceStack stack = Read(OneBand().Build());
  EXPECT_EQ(stack.bands.size(), 1u);
  EXPECT_EQ(stack.bands[0].fwhm_nm, 0.0);
  EXPECT_FALSE(stack.pixel_size_mm);
  EXPECT_FALSE(stack.shared_error);
  EXPECT_EQ(stack.illumination, Illumination::kWindow);
  EXPECT_EQ(stack.tape, Tape::kFree);
  EXPECT_EQ(stack.geometry, Geometry::kHemispherical);
}

// Half floats keep such fractions exactly; integers keep their value (1 is valid, not 1/4294967295).
TEST_F(StackExrTest, AcceptsHalfAndIntegerChannelsAndAnyDataWindow) {
  const ReflectanceStack stack =
      Read(ExrBuilder(4, 3)
               .Origin(-7, 100)
               .Channel("T.450,000000nm", ExrType::kHalf, Gradient)
               .Channel("valid", ExrType::kUint, [](int x, int) { return x > 0 ? 1 : 0; })
               .Build());
  EXPECT_EQ(stack.width(), 4);
  EXPECT_EQ(stack.height(), 3);
  EXPECT_EQ(stack.reflectance[0](3, 2), 7.0f / 64.0f);
  EXPECT_EQ(stack.reflectance[0](0, 1), 2.0f / 64.0f);
  EXPECT_EQ(stack.valid(0, 2), 0.0f);
  EXPECT_EQ(stack.valid(1, 2), 1.0f);
}

// Missing values stay missing, and infinite ones are missing too.
TEST_F(StackExrTest, KeepsNanAndTurnsInfinityIntoNan) {
  const ReflectanceStack stack =
      Read(ExrBuilder(4, 3)
               .Channel("T.450,000000nm", ExrType::kFloat,
                        [](int x, int) {
                          return x == 0 ? NAN : x == 1 ? INFINITY : x == 2 ? -INFINITY : 0.25;
                        })
               .Build());
  for (int x = 0; x < 3; ++x) EXPECT_TRUE(std::isnan(stack.reflectance[0](x, 1))) << x;
  EXPECT_EQ(stack.reflectance[0](3, 1), 0.25f);
  EXPECT_THAT(
      SentenceFor(ExrBuilder(4, 3).Channel("T.450nm", ExrType::kFloat, [](int, int) { return NAN; }).Build()),
      AllOf(HasSubstr("some.exr"), HasSubstr("every pixel of every band is missing")));
}

// What is no reflectance, or contradicts itself, is told in one sentence that names file, found and expected.
TEST_F(StackExrTest, RejectsWhatIsNoReflectanceStack) {
  const auto half = [](int, int) { return 0.5; };
  EXPECT_THAT(SentenceFor(ExrBuilder(4, 3).Channel("S0.450,000000nm", ExrType::kFloat, half).Build()),
              AllOf(HasSubstr("some.exr"), HasSubstr("emissive"), HasSubstr("T.450,000000nm")));
  EXPECT_THAT(SentenceFor(ExrBuilder(4, 3).Channel("R", ExrType::kFloat, half).Build()),
              AllOf(HasSubstr("no reflectance channel"), HasSubstr("its channels: R")));
  EXPECT_THAT(SentenceFor(OneBand().Channel("T.red", ExrType::kFloat, half).Build()), HasSubstr("'T.red'"));
  EXPECT_THAT(SentenceFor(OneBand().Channel("T.0,45um", ExrType::kFloat, half).Build()),
              HasSubstr("two bands at 450"));
  EXPECT_THAT(SentenceFor(OneBand().Channel("T.340,000000nm", ExrType::kFloat, half).Build()),
              AllOf(HasSubstr("340 nm"), HasSubstr("350 to 1000")));
  EXPECT_THAT(SentenceFor(OneBand()
                              .Channel("T.500,000000nm", ExrType::kFloat, half)
                              .Channel("sigma.450,000000nm", ExrType::kFloat, half)
                              .Build()),
              HasSubstr("sigma for 1 of its 2 bands"));
  EXPECT_THAT(SentenceFor(OneBand().Channel("sigma.500,000000nm", ExrType::kFloat, half).Build()),
              HasSubstr("sigma at 500 nm"));
  EXPECT_THAT(
      SentenceFor(
          OneBand().Channel("sigma.450,000000nm", ExrType::kFloat, [](int, int) { return -1; }).Build()),
      HasSubstr("0 or more"));
  EXPECT_THAT(
      SentenceFor(
          ExrBuilder(4, 3).Channel("T.450nm", ExrType::kFloat, [](int, int) { return 45.0; }).Build()),
      AllOf(HasSubstr("median of 45"), HasSubstr("fraction")));
}

// Attributes of the wrong kind or value name what is allowed.
TEST_F(StackExrTest, RejectsAttributesThatCannotBe) {
  EXPECT_THAT(
      SentenceFor(OneBand().Text("dermap:illumination", "windowed").Build()),
      AllOf(HasSubstr("dermap:illumination"), HasSubstr("\"windowed\""), HasSubstr("window or uniform")));
  EXPECT_THAT(SentenceFor(OneBand().Text("dermap:tape", "").Build()), HasSubstr("free or black"));
  EXPECT_THAT(SentenceFor(OneBand().Text("dermap:geometry", "0/45").Build()),
              HasSubstr("hemispherical or 0/30"));
  EXPECT_THAT(SentenceFor(OneBand().Float("dermap:tape", 1).Build()), HasSubstr("expected a text"));
  EXPECT_THAT(SentenceFor(OneBand().Float("dermap:pixelSizeMm", 0).Build()), HasSubstr("0.0001 to 100"));
  EXPECT_THAT(SentenceFor(OneBand().Float("dermap:pixelSizeMm", NAN).Build()), HasSubstr("0.0001 to 100"));
  EXPECT_THAT(SentenceFor(OneBand().Text("dermap:pixelSizeMm", "0.03").Build()), HasSubstr("not a number"));
  EXPECT_THAT(SentenceFor(OneBand().Float("dermap:sharedError", NAN).Build()), HasSubstr("0 to 0.1"));
  EXPECT_THAT(SentenceFor(OneBand().Float("dermap:sharedError", 0.2f).Build()), HasSubstr("0 to 0.1"));
  EXPECT_THAT(SentenceFor(OneBand().Text("dermap:sharedError", "0").Build()), HasSubstr("not a number"));
  EXPECT_THAT(SentenceFor(OneBand().Floats("dermap:fwhmNm", {10, 10}).Build()),
              HasSubstr("has 2 values; expected 1"));
  EXPECT_THAT(SentenceFor(OneBand().Floats("dermap:fwhmNm", {-1}).Build()), HasSubstr("width of -1 nm"));
  EXPECT_THAT(SentenceFor(OneBand().Floats("dermap:noiseCorrelationX", {0.5f, 1.5f}).Build()),
              HasSubstr("between -1 and 1"));
  EXPECT_THAT(SentenceFor(OneBand().Floats("dermap:noiseCorrelationY", std::vector<float>(17, 0.1f)).Build()),
              HasSubstr("at most 16"));
  EXPECT_THAT(SentenceFor(OneBand().Text("dermap:noiseCorrelationX", "0.5").Build()),
              HasSubstr("not a list of floats"));
  EXPECT_THAT(SentenceFor(OneBand().Text("spectralLayoutVersion", "2.0").Build()), HasSubstr("expected 1.0"));
}

// Other writers hold short lists as vectors: OpenImageIO writes two floats as v2f and one as a float.
TEST_F(StackExrTest, ReadsWidthsHoweverTheyWereWritten) {
  EXPECT_EQ(Read(OneBand().Float("dermap:fwhmNm", 12.5f).Build()).bands[0].fwhm_nm, 12.5);
  const float two[] = {10.0f, 12.5f};
  const std::string bytes(reinterpret_cast<const char*>(two), sizeof two);
  const auto half = [](int, int) { return 0.5; };
  const ReflectanceStack stack = Read(
      OneBand().Channel("T.500,000000nm", ExrType::kFloat, half).Raw("dermap:fwhmNm", "v2f", bytes).Build());
  EXPECT_EQ(stack.bands[1].fwhm_nm, 12.5);
}

// An extension that says nothing of ours; the format is chosen by it.
TEST_F(StackExrTest, NamesTheExtensionsThatItKnows) {
  folder_.Write("x.tif", "");
  EXPECT_THAT(SentenceOf<InputError>([&] { ReadReflectanceStack(folder_ / "x.tif"); }),
              AllOf(HasSubstr("'.tif'"), HasSubstr(".exr"), HasSubstr(".hdr")));
  EXPECT_THAT(SentenceOf<InputError>([&] { WriteReflectanceStack(folder_ / "x", MakeStack()); }),
              HasSubstr("''"));
  EXPECT_THAT(SentenceOf<InputError>([&] { ReadReflectanceStack(folder_ / "none.exr"); }),
              AllOf(HasSubstr("none.exr"), HasSubstr("No such file")));
}

}  // namespace
}  // namespace dermap
