// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "common/files/stack.h"
#include "tests/common/files/temporary_folder.h"

namespace dermap {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::UnorderedElementsAre;

constexpr int kWidth = 3, kHeight = 2, kBands = 2;

// The image that every file below holds: all values differ, and all are whole after * 1000.
double Value(int x, int y, int band) {
  return (100 * band + 10 * y + x) / 1000.0;
}

template <class T>
std::string Bytes(T value, bool big_endian) {
  std::string bytes(sizeof value, '\0');
  std::memcpy(bytes.data(), &value, sizeof value);
  if (big_endian) std::reverse(bytes.begin(), bytes.end());
  return bytes;
}

// NV5 Geospatial, "ENVI Image Files": BSQ is band by band, BIL line by line, BIP pixel by pixel.
template <class T>
std::string Data(const std::string& interleave, double scale, bool big_endian = false) {
  std::string bytes;
  const auto add = [&](int x, int y, int band) {
    bytes += Bytes(static_cast<T>(std::round(Value(x, y, band) * 1000) / 1000 * scale), big_endian);
  };
  if (interleave == "bsq") {
    for (int band = 0; band < kBands; ++band)
      for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) add(x, y, band);
  } else if (interleave == "bil") {
    for (int y = 0; y < kHeight; ++y)
      for (int band = 0; band < kBands; ++band)
        for (int x = 0; x < kWidth; ++x) add(x, y, band);
  } else {
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x)
        for (int band = 0; band < kBands; ++band) add(x, y, band);
  }
  return bytes;
}

std::string Header(const std::string& more, int type = 4, const std::string& interleave = "bsq") {
  return "ENVI\ndescription = {\n  two bands }\nsamples = 3\nlines   = 2\nbands   = 2\nheader offset = 0\n"
         "file type = ENVI Standard\ndata type = " +
         std::to_string(type) + "\ninterleave = " + interleave + "\n" + more;
}
const std::string kNm = "wavelength units = Nanometers\nwavelength = {\n 450.5,\n 600}\n";

class StackEnviTest : public testing::Test {
 protected:
  ReflectanceStack Read(const std::string& header, const std::string& data,
                        const std::string& extension = ".img") {
    folder_.Write("a" + extension, data);
    return ReadReflectanceStack(folder_.Write("a.hdr", header));
  }
  std::string SentenceFor(const std::string& header, const std::string& data) {
    return SentenceOf<InputError>([&] { Read(header, data); });
  }
  void ExpectTheImage(const ReflectanceStack& stack) {
    ASSERT_EQ(stack.bands.size(), 2u);
    ASSERT_EQ(stack.width(), kWidth);
    ASSERT_EQ(stack.height(), kHeight);
    EXPECT_DOUBLE_EQ(stack.bands[0].wavelength_nm, 450.5);
    for (int band = 0; band < kBands; ++band)
      for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) {
          EXPECT_NEAR(stack.reflectance[static_cast<std::size_t>(band)](x, y), Value(x, y, band), 1e-7);
        }
  }
  TemporaryFolder folder_;
};

// Every numeric type of ENVI's table that we read (1, 2, 3, 4, 5, 12, 13), each interleave, both byte orders.
TEST_F(StackEnviTest, ReadsEveryTypeInterleaveAndByteOrder) {
  for (const std::string interleave : {"bsq", "bil", "bip"}) {
    for (const bool big : {false, true}) {
      SCOPED_TRACE(interleave + (big ? " big" : " little"));
      const std::string more = kNm + "byte order = " + (big ? "1" : "0") + "\n";
      const std::string scaled = more + "reflectance scale factor = 1000\n";
      ExpectTheImage(Read(Header(more, 4, interleave), Data<float>(interleave, 1, big)));
      ExpectTheImage(Read(Header(more, 5, interleave), Data<double>(interleave, 1, big)));
      ExpectTheImage(Read(Header(scaled, 1, interleave), Data<std::uint8_t>(interleave, 1000, big)));
      ExpectTheImage(Read(Header(scaled, 2, interleave), Data<std::int16_t>(interleave, 1000, big)));
      ExpectTheImage(Read(Header(scaled, 3, interleave), Data<std::int32_t>(interleave, 1000, big)));
      ExpectTheImage(Read(Header(scaled, 12, interleave), Data<std::uint16_t>(interleave, 1000, big)));
      ExpectTheImage(Read(Header(scaled, 13, interleave), Data<std::uint32_t>(interleave, 1000, big)));
    }
  }
}

// Data under each of the usual names, with an offset, and in micrometres.
TEST_F(StackEnviTest, FindsTheDataAndUnderstandsUnits) {
  for (const char* extension : {"", ".img", ".dat", ".raw", ".bsq"}) {
    ExpectTheImage(Read(Header(kNm), Data<float>("bsq", 1), extension));
    std::filesystem::remove(folder_ / ("a" + std::string(extension)));
  }
  folder_.Write("b.img", Data<float>("bsq", 1));
  ExpectTheImage(ReadReflectanceStack(folder_.Write("b.img.hdr", Header(kNm))));
  const std::string micrometres =
      "wavelength units = Micrometers\nwavelength = {0.4505, 0.6}\nfwhm = {0.01, 0.012}\n";
  const ReflectanceStack stack =
      Read(Header(micrometres + "header offset = 5\n"), "12345" + Data<float>("bsq", 1));
  ExpectTheImage(stack);
  EXPECT_NEAR(stack.bands[1].fwhm_nm, 12.0, 1e-9);
  ExpectTheImage(Read(Header("wavelength = {0.4505, 0.6}\n"), Data<float>("bsq", 1)));
}

// ENVI's own keys: bad bands are left out, ignored values are missing; ours are the contract's.
TEST_F(StackEnviTest, UnderstandsBadBandsIgnoredValuesAndOurKeys) {
  ReflectanceStack stack = Read(Header(kNm + "bbl = {0, 1}\n"), Data<float>("bsq", 1));
  ASSERT_EQ(stack.bands.size(), 1u);
  EXPECT_EQ(stack.bands[0].wavelength_nm, 600.0);
  EXPECT_NEAR(stack.reflectance[0](2, 1), Value(2, 1, 1), 1e-7);
  stack = Read(Header(kNm + "reflectance scale factor = 1000\ndata ignore value = 11\n", 2),
               Data<std::int16_t>("bsq", 1000));
  EXPECT_TRUE(std::isnan(stack.reflectance[0](1, 1)));
  EXPECT_NEAR(stack.reflectance[0](2, 1), 0.012, 1e-7);
  EXPECT_FALSE(stack.pixel_size_mm);
  stack = Read(Header(kNm + "Dermap Pixel Size mm = 0.03\ndermap tape = black\ndermap geometry = 0/30\n"),
               Data<float>("bsq", 1));
  EXPECT_EQ(stack.pixel_size_mm, 0.03);
  EXPECT_EQ(stack.tape, Tape::kBlack);
  EXPECT_EQ(stack.geometry, Geometry::kFactor0_30);
  EXPECT_EQ(stack.illumination, Illumination::kWindow);
}

// What was written comes back, sigma, mask and notes included; the files are the ones that formats.md lists.
TEST_F(StackEnviTest, ComesBackAsWritten) {
  ReflectanceStack written;
  written.bands = {{450.25, 10.0}, {600.0, 0.0}};
  for (int i = 0; i < 2; ++i) {
    written.reflectance.emplace_back(5, 4, 0.25f + 0.5f * static_cast<float>(i));
    written.sigma.emplace_back(5, 4, 0.01f * static_cast<float>(i + 1));
  }
  written.reflectance[0](4, 0) = 0.125f;
  written.reflectance[1](0, 3) = std::numeric_limits<float>::quiet_NaN();
  written.valid = PlaneF(5, 4, 1.0f);
  written.valid(3, 2) = 0.0f;
  written.pixel_size_mm = 0.029296875;
  written.shared_error = 0.002;
  written.illumination = Illumination::kUniform;
  written.noise_correlation_x = {0.4f, -0.05f};
  written.noise_correlation_y = {0.3f};
  written.notes["subject"] = "S01 = {left}";
  WriteReflectanceStack(folder_ / "s.hdr", written);
  EXPECT_THAT(folder_.Names(), UnorderedElementsAre("s.hdr", "s.img", "s_sigma.hdr", "s_sigma.img",
                                                    "s_valid.hdr", "s_valid.img"));
  EXPECT_EQ(std::filesystem::file_size(folder_ / "s.img"), 2u * 5u * 4u * 4u);
  const ReflectanceStack read = ReadReflectanceStack(folder_ / "s.hdr");
  ASSERT_EQ(read.bands.size(), 2u);
  EXPECT_EQ(read.bands[0].wavelength_nm, 450.25);
  EXPECT_EQ(read.bands[0].fwhm_nm, 10.0);
  EXPECT_EQ(read.reflectance[0](4, 0), 0.125f);
  EXPECT_TRUE(std::isnan(read.reflectance[1](0, 3)));
  EXPECT_EQ(read.sigma[1](2, 2), 0.02f);
  EXPECT_EQ(read.valid(3, 2), 0.0f);
  EXPECT_EQ(read.valid(2, 3), 1.0f);
  EXPECT_EQ(read.pixel_size_mm, 0.029296875);
  EXPECT_EQ(read.shared_error, 0.002);
  EXPECT_EQ(read.illumination, Illumination::kUniform);
  EXPECT_EQ(read.noise_correlation_x, written.noise_correlation_x);
  EXPECT_EQ(read.noise_correlation_y, written.noise_correlation_y);
  EXPECT_EQ(read.notes.at("subject"), "S01 = (left)") << "braces would open a list";
}

// Each mistake in one sentence with file and key.
TEST_F(StackEnviTest, RejectsHeadersThatCannotBe) {
  const std::string data = Data<float>("bsq", 1);
  EXPECT_THAT(SentenceFor("not ENVI\n", data), AllOf(HasSubstr("a.hdr"), HasSubstr("not an ENVI header")));
  EXPECT_THAT(SentenceFor("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n", data), HasSubstr("not an ENVI header"));
  EXPECT_THAT(SentenceFor("ENVI\nlines = 2\n", data), HasSubstr("'samples' is missing"));
  EXPECT_THAT(SentenceFor(Header(""), data), HasSubstr("'wavelength' has 0 values"));
  EXPECT_THAT(SentenceFor(Header("wavelength = {450, 500, 550}\n"), data), HasSubstr("has 3 values"));
  EXPECT_THAT(SentenceFor(Header("wavelength = {450, red}\n"), data), HasSubstr("holds \"red\""));
  EXPECT_THAT(SentenceFor(Header("wavelength = {450, \n"), data), HasSubstr("never closed"));
  EXPECT_THAT(SentenceFor(Header("wavelength = {450, 450}\n"), data), HasSubstr("two bands at 450"));
  EXPECT_THAT(SentenceFor(Header("wavelength = {450, 2500}\n"), data), HasSubstr("2500 nm"));
  EXPECT_THAT(SentenceFor(Header("wavelength units = Index\nwavelength = {1, 2}\n"), data),
              HasSubstr("\"index\""));
  EXPECT_THAT(SentenceFor(Header(kNm + "what is this\n"), data), HasSubstr("expected KEY = VALUE"));
  EXPECT_THAT(SentenceFor(Header(kNm, 6), data), HasSubstr("'data type' is 6"));
  EXPECT_THAT(SentenceFor(Header(kNm, 2), data), HasSubstr("reflectance scale factor"));
  EXPECT_THAT(SentenceFor(Header(kNm, 4, "tiles"), data), HasSubstr("bsq, bil or bip"));
  EXPECT_THAT(SentenceFor(Header(kNm + "samples = 1e6\n"), data), HasSubstr("pixels a side"));
  EXPECT_THAT(SentenceFor(Header(kNm + "samples = 2.5\n"), data), HasSubstr("expected an integer"));
  EXPECT_THAT(SentenceFor(Header(kNm + "dermap pixel size mm = -1\n"), data), HasSubstr("0.0001 to 100"));
  EXPECT_THAT(SentenceFor(Header(kNm + "dermap illumination = flash\n"), data),
              HasSubstr("window or uniform"));
  EXPECT_THAT(SentenceFor(Header(kNm + "dermap sigma header = ../x.hdr\n"), data), HasSubstr("beside it"));
  EXPECT_THAT(SentenceFor(Header(kNm + "dermap sigma header = none.hdr\n"), data), HasSubstr("none.hdr"));
  EXPECT_THAT(SentenceFor(Header(kNm + "dermap noise correlation x = {2}\n"), data),
              HasSubstr("between -1 and 1"));
  EXPECT_THAT(SentenceFor(Header(kNm + "bbl = {0, 0}\n"), data), HasSubstr("every band as bad"));
}

// Data that end too early, by one byte; data that are not there.
TEST_F(StackEnviTest, NamesDataThatAreIncompleteOrMissing) {
  std::string data = Data<float>("bsq", 1);
  data.pop_back();
  EXPECT_THAT(SentenceFor(Header(kNm), data), AllOf(HasSubstr("a.img has 47 bytes"), HasSubstr("48")));
  std::filesystem::remove(folder_ / "a.img");
  EXPECT_THAT(SentenceOf<InputError>([&] { ReadReflectanceStack(folder_ / "a.hdr"); }),
              HasSubstr("not beside the header"));
}

}  // namespace
}  // namespace dermap
