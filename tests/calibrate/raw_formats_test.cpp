// SPDX-License-Identifier: Apache-2.0
// Cameras' own formats: the photosites that were written, in the filters' order, with the levels that the
// file tells.
#include <gtest/gtest.h>
#include <libraw/libraw.h>

#include <array>
#include <numeric>

#include "calibrate/raw_frame.h"
#include "common/core/error.h"
#include "common/files/atomic_file.h"
#include "tests/calibrate/camera_files.h"
#include "tests/common/files/temporary_folder.h"

namespace dermap {
namespace {

// Every value from 0 to below 2^bits comes up somewhere, neighbours differ much.
Plane<std::uint16_t> Photosites(int width, int height, int bits) {
  Plane<std::uint16_t> plane(width, height);
  for (std::size_t i = 0; i < plane.size(); ++i)
    plane.data()[i] = static_cast<std::uint16_t>(i * 7919 % (std::size_t{1} << bits));
  return plane;
}

class RawFormats : public ::testing::Test {
 protected:
  BayerFrame Read(const std::string& name, const std::vector<std::byte>& bytes) {
    WriteFileAtomically(folder_.path() / name, bytes);
    return ReadBayerFrame(folder_.path() / name);
  }
  TemporaryFolder folder_;
};

void ExpectSame(const BayerFrame& frame, const Plane<std::uint16_t>& photosites) {
  ASSERT_TRUE(frame.values.SameShape(photosites));
  for (std::size_t i = 0; i < photosites.size(); ++i)
    ASSERT_EQ(frame.values.data()[i], photosites.data()[i]) << i;
  EXPECT_EQ(frame.period, 2);
  EXPECT_NEAR(frame.exposure_ms, 12.5, 1e-3);
  EXPECT_EQ(frame.iso, 320);
}

using Colours = std::array<char, kLatticeCount>;

void ExpectLevels(const BayerFrame& frame, const Colours& colours, double black, int white) {
  EXPECT_EQ(frame.colours, colours);
  EXPECT_EQ(frame.black_level, black);
  EXPECT_EQ(frame.white_level, white);
}

// The values written; a black level of each colour, of which the frame states the mean: (600 + ... + 606)
// / 4.
TEST_F(RawFormats, NefOf14Bits) {
  const auto photosites = Photosites(96, 64, 14);
  const BayerFrame frame = Read(
      "a.nef",
      EncodeNef(photosites, {"NIKON CORPORATION", "NIKON D9999", 14, {1, 2, 0, 1}, {600, 602, 604, 606}, 6}));
  ExpectSame(frame, photosites);
  ExpectLevels(frame, {'G', 'B', 'R', 'G'}, 603.0, 16383);
}

// Nikon states black levels in steps of 14 bits: 600 are 150 of 12 bits.
TEST_F(RawFormats, NefOf12BitsPacked) {
  const auto photosites = Photosites(96, 64, 12);
  const BayerFrame frame = Read(
      "a.nef",
      EncodeNef(photosites, {"NIKON CORPORATION", "NIKON D9999", 12, {0, 1, 1, 2}, {600, 600, 600, 600}}));
  ExpectSame(frame, photosites);
  ExpectLevels(frame, {'R', 'G', 'G', 'B'}, 150.0, 4095);
}

// DNG 1.4, "BitsPerSample" and "LinearizationTable": 10 to 16 bits, rows of any length; stored numbers that
// mean others.
TEST_F(RawFormats, DngOfEveryDepth) {
  for (const int bits : {10, 12, 14, 16}) {
    for (const int width : {96, 77}) {
      const auto photosites = Photosites(width, 64, bits);
      const BayerFrame frame =
          Read("a.dng", EncodeCameraDng(photosites, {"Maker", "Camera", bits, {0, 1, 1, 2}, {100}}));
      ExpectSame(frame, photosites);
      ExpectLevels(frame, {'R', 'G', 'G', 'B'}, 100.0, (1 << bits) - 1);
    }
  }
  CameraFile bent{"Maker", "Camera", 12, {0, 1, 1, 2}, {100}};
  for (std::uint32_t v = 0; v < 4096; ++v) bent.curve.push_back(v + v * v / 512);
  auto photosites = Photosites(96, 64, 12);
  const BayerFrame frame = Read("bent.dng", EncodeCameraDng(photosites, bent));
  for (auto& v : photosites.values()) v = static_cast<std::uint16_t>(bent.curve[v]);
  ExpectSame(frame, photosites);
}

// DNG 1.4, compression 7: tiles of 40 photosites, the last one partly beyond the frame.
TEST_F(RawFormats, DngOfLosslessTiles) {
  for (const int bits : {12, 14, 16}) {
    const auto photosites = Photosites(96, 64, bits);
    const BayerFrame frame =
        Read("a.dng", EncodeLosslessDng(photosites, {"Maker", "Camera", bits, {0, 1, 1, 2}, {100}}, 40));
    ExpectSame(frame, photosites);
    ExpectLevels(frame, {'R', 'G', 'G', 'B'}, 100.0, (1 << bits) - 1);
  }
}

// The values written.
TEST_F(RawFormats, NefOfLosslessCompression) {
  for (const int bits : {12, 14}) {
    const auto photosites = Photosites(96, 64, bits);
    const BayerFrame frame =
        Read("a.nef",
             EncodeLosslessNef(
                 photosites, {"NIKON CORPORATION", "NIKON D9999", bits, {0, 1, 1, 2}, {600, 600, 600, 600}}));
    ExpectSame(frame, photosites);
    ExpectLevels(frame, {'R', 'G', 'G', 'B'}, bits == 14 ? 600.0 : 150.0, (1 << bits) - 1);
  }
}

// The values written: steps of 2 below 4096, each group of 16 within 126 steps, which is what 7 bits hold.
TEST_F(RawFormats, ArwOfSonysCompression) {
  Plane<std::uint16_t> photosites(96, 64);
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 96; ++x)
      photosites(x, y) =
          static_cast<std::uint16_t>(2 * (100 + 25 * y + 40 * (x % 2) + (7 * x + 3 * y) % 120));
  }
  const BayerFrame frame =
      Read("a.arw",
           EncodeCompressedArw(photosites, {"SONY", "ILCE-9999", 12, {0, 1, 1, 2}, {512, 512, 512, 512}}));
  ExpectSame(frame, photosites);
  EXPECT_EQ(frame.colours, (Colours{'R', 'G', 'G', 'B'}));
}

TEST_F(RawFormats, ArwInEachPhaseOfTheFilters) {
  const auto photosites = Photosites(96, 64, 14);
  const std::array<std::array<std::uint8_t, 4>, 4> phases{
      {{0, 1, 1, 2}, {1, 0, 2, 1}, {1, 2, 0, 1}, {2, 1, 1, 0}}};
  const std::array<Colours, 4> expected{
      {{'R', 'G', 'G', 'B'}, {'G', 'R', 'B', 'G'}, {'G', 'B', 'R', 'G'}, {'B', 'G', 'G', 'R'}}};
  for (std::size_t i = 0; i < phases.size(); ++i) {
    const BayerFrame frame =
        Read("a.arw", EncodeArw(photosites, {"SONY", "ILCE-9999", 14, phases[i], {512, 512, 512, 512}}));
    ExpectSame(frame, photosites);
    ExpectLevels(frame, expected[i], 512.0, 16383);
  }
}

// Strips of 40 photosites side by side, the last of 16, as Canon's cameras cut their frames.
TEST_F(RawFormats, Cr2WholeAndInStrips) {
  const auto photosites = Photosites(96, 64, 14);
  for (const int strip_width : {0, 40}) {
    const BayerFrame frame =
        Read("a.cr2", EncodeCr2(photosites, {"Canon", "Canon EOS 9999D", 14, {}, {}, 8}, strip_width));
    ExpectSame(frame, photosites);
    EXPECT_EQ(frame.colours, (Colours{'R', 'G', 'G', 'B'}));
    EXPECT_EQ(frame.white_level, 16383);
  }
}

// A Canon sensor of this size is known to have 48 covered columns on its left and 6 rows above: they are no
// part of the frame, and tell its black level.
TEST_F(RawFormats, Cr2WithCoveredMargins) {
  auto sensor = Photosites(2224, 1456, 12);
  for (int y = 0; y < sensor.height(); ++y) std::fill_n(sensor.Row(y), 48, std::uint16_t{131});
  const BayerFrame frame = Read("a.cr2", EncodeCr2(sensor, {"Canon", "Canon EOS D30", 12}));
  ASSERT_EQ(frame.values.width(), 2224 - 48);
  ASSERT_EQ(frame.values.height(), 1456 - 6 - 2);
  for (int y = 0; y < frame.values.height(); ++y) {
    ASSERT_TRUE(
        std::equal(frame.values.Row(y), frame.values.Row(y) + frame.values.width(), sensor.Row(y + 6) + 48))
        << y;
  }
  EXPECT_EQ(frame.black_level, 131.0);
  EXPECT_EQ(frame.white_level, 4095);
}

// LibRaw's own decoder: the same values, margins and levels, for any layout of strips and any depth.
TEST_F(RawFormats, Cr2AsLibRawReadsIt) {
  for (const int bits : {12, 14}) {
    for (const auto& [width, strip_width] : {std::pair{96, 0}, {96, 40}, {96, 48}, {100, 26}}) {
      const auto bytes =
          EncodeCr2(Photosites(width, 64, bits), {"Canon", "Canon EOS 9999D", bits}, strip_width);
      const BayerFrame frame = Read("a.cr2", bytes);
      LibRaw slow;
      ASSERT_EQ(slow.open_file((folder_.path() / "a.cr2").c_str()), LIBRAW_SUCCESS);
      ASSERT_EQ(slow.unpack(), LIBRAW_SUCCESS);
      const auto& sizes = slow.imgdata.sizes;
      ASSERT_TRUE(frame.values.SameShape(sizes.width, sizes.height)) << width << " " << strip_width;
      EXPECT_EQ(frame.white_level, slow.imgdata.color.maximum);
      for (int y = 0; y < sizes.height; ++y) {
        const auto* row =
            slow.imgdata.rawdata.raw_image + (y + sizes.top_margin) * sizes.raw_pitch / 2 + sizes.left_margin;
        ASSERT_TRUE(std::equal(row, row + sizes.width, frame.values.Row(y)))
            << bits << " bits, " << width << " wide, strips of " << strip_width << ", row " << y;
      }
    }
  }
}

// By definition: data cut short are no frame, whoever decodes them.
TEST_F(RawFormats, CompressedFilesCutShortAreRefused) {
  const auto photosites = Photosites(96, 64, 12);
  const std::vector<std::pair<const char*, std::vector<std::byte>>> files{
      {"a.cr2", EncodeCr2(photosites, {"Canon", "Canon EOS 9999D", 12})},
      {"a.dng", EncodeLosslessDng(photosites, {"Maker", "Camera", 12}, 48)},
      {"a.nef", EncodeLosslessNef(photosites, {"NIKON CORPORATION", "NIKON D9999", 12})}};
  for (const auto& [name, bytes] : files) {
    for (const double share : {0.5, 0.9, 0.99}) {
      const auto length = static_cast<std::ptrdiff_t>(share * double(bytes.size()));
      EXPECT_THROW(Read(name, {bytes.begin(), bytes.begin() + length}), InputError) << name << " " << share;
    }
  }
}

}  // namespace
}  // namespace dermap
