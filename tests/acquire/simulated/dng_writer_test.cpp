// SPDX-License-Identifier: Apache-2.0
// The DNG files of the simulated camera, read back by LibRaw, which shares no code with the writer.
#include "acquire/simulated/dng_writer.h"

#include <gtest/gtest.h>
#include <libraw/libraw.h>

#include <memory>
#include <random>

namespace dermap {
namespace {

Plane<std::uint16_t> RandomMosaic(int width, int height, std::uint32_t seed) {
  Plane<std::uint16_t> bayer(width, height);
  std::mt19937 random(seed);
  for (auto& v : bayer.values()) v = static_cast<std::uint16_t>(random() & 0xFFF);
  bayer(0, 0) = 0;  // both ends of the range are there
  bayer(1, 0) = 4095;
  return bayer;
}

std::unique_ptr<LibRaw> Unpacked(const std::vector<std::byte>& file) {
  auto raw = std::make_unique<LibRaw>();
  EXPECT_EQ(raw->open_buffer(const_cast<std::byte*>(file.data()), file.size()), LIBRAW_SUCCESS);
  EXPECT_EQ(raw->unpack(), LIBRAW_SUCCESS);
  return raw;
}

// The mosaic that was written is the truth.
TEST(DngWriter, LibRawReturnsEveryPhotosite) {
  for (const auto& [width, height] : {std::pair{480, 360}, {64, 34}, {502, 334}}) {
    const auto bayer = RandomMosaic(width, height, 7);
    const auto file = EncodeDng(bayer, {});
    const auto raw = Unpacked(file);
    const auto& sizes = raw->imgdata.sizes;
    ASSERT_EQ(sizes.raw_width, width);
    ASSERT_EQ(sizes.raw_height, height);
    EXPECT_EQ(sizes.width, width);
    EXPECT_EQ(sizes.height, height);
    EXPECT_EQ(sizes.flip, 0);
    int different = 0;
    for (int y = 0; y < height; ++y) {
      const auto* row = raw->imgdata.rawdata.raw_image + static_cast<std::size_t>(y) * sizes.raw_pitch / 2;
      for (int x = 0; x < width; ++x) different += row[x] != bayer(x, y);
    }
    EXPECT_EQ(different, 0) << width << " x " << height;
  }
}

// The metadata that was written is the truth.
TEST(DngWriter, LibRawReturnsLevelsPatternAndExif) {
  DngMetadata metadata;
  metadata.exposure_ms = 10.0;
  metadata.iso = 250;
  metadata.black_level = 126;
  metadata.description = "a description of odd length, with 7";
  const auto raw = Unpacked(EncodeDng(RandomMosaic(480, 360, 3), metadata));
  EXPECT_EQ(raw->imgdata.color.black + raw->imgdata.color.cblack[0], 126u);
  EXPECT_EQ(raw->imgdata.color.maximum, 4095u);
  EXPECT_STREQ(raw->imgdata.idata.make, "dermap");
  EXPECT_NEAR(raw->imgdata.other.shutter, 0.010, 1e-6);
  EXPECT_NEAR(raw->imgdata.other.iso_speed, 250.0, 1e-3);
  EXPECT_STREQ(raw->imgdata.other.desc, metadata.description.c_str());
  EXPECT_EQ(raw->imgdata.idata.colors, 3);
  const char* names = raw->imgdata.idata.cdesc;
  EXPECT_EQ(names[raw->COLOR(0, 0)], 'R');
  EXPECT_EQ(names[raw->COLOR(0, 1)], 'G');
  EXPECT_EQ(names[raw->COLOR(1, 0)], 'G');
  EXPECT_EQ(names[raw->COLOR(1, 1)], 'B');
}

// Two photosites in three bytes: arithmetic. The rest is the directories.
TEST(DngWriter, IsPacked) {
  const auto file = EncodeDng(RandomMosaic(480, 360, 3), {});
  EXPECT_GE(file.size(), 480u * 360u * 3 / 2);
  EXPECT_LT(file.size(), 480u * 360u * 3 / 2 + 2048);
}

}  // namespace
}  // namespace dermap
