// SPDX-License-Identifier: Apache-2.0
// Decoding against the values that were written, and against OpenImageIO's decoder.
#include "calibrate/raw_frame.h"

#include <OpenImageIO/imageio.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <libraw/libraw.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <random>

#include "acquire/simulated/dng_writer.h"
#include "calibrate/unpack_bits.h"
#include "common/core/error.h"
#include "common/files/atomic_file.h"

namespace dermap {
namespace {

using ::testing::HasSubstr;

class RawFrameFile : public ::testing::Test {
 protected:
  RawFrameFile() {
    folder_ = std::filesystem::temp_directory_path() /
              ("dermap_raw_" + std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()));
    std::filesystem::create_directories(folder_);
  }
  ~RawFrameFile() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path Write(const std::string& name, std::span<const std::byte> bytes) {
    WriteFileAtomically(folder_ / name, bytes);
    return folder_ / name;
  }
  std::filesystem::path folder_;
};

Plane<std::uint16_t> RandomBayer(int width, int height) {
  Plane<std::uint16_t> bayer(width, height);
  std::mt19937 random(1);
  for (auto& v : bayer.values()) v = static_cast<std::uint16_t>(random() % 4096);
  return bayer;
}

std::string ErrorOf(const std::filesystem::path& path) {
  try {
    ReadBayerFrame(path);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

// The values written.
TEST_F(RawFrameFile, GivesBackEveryPhotositeExactly) {
  const auto bayer = RandomBayer(96, 64);
  DngMetadata metadata;
  metadata.exposure_ms = 12.5;
  metadata.iso = 320;
  const BayerFrame frame = ReadBayerFrame(Write("a.dng", EncodeDng(bayer, metadata)));
  ASSERT_TRUE(frame.values.SameShape(bayer));
  for (std::size_t i = 0; i < bayer.size(); ++i) ASSERT_EQ(frame.values.data()[i], bayer.data()[i]) << i;
  EXPECT_EQ(frame.colours, (std::array<char, 4>{'R', 'G', 'G', 'B'}));
  EXPECT_EQ(frame.black_level, metadata.black_level);
  EXPECT_EQ(frame.white_level, kDngWhiteLevel);
  EXPECT_NEAR(frame.exposure_ms, 12.5, 1e-3);
  EXPECT_EQ(frame.iso, 320);
}

// OpenImageIO's raw reader without demosaicing: another path through the file, the same numbers.
TEST_F(RawFrameFile, AgreesWithOpenImageIO) {
  const auto path = Write("a.dng", EncodeDng(RandomBayer(96, 64), {}));
  const BayerFrame frame = ReadBayerFrame(path);
  OIIO::ImageSpec request;
  request["raw:Demosaic"] = "none";
  request["raw:user_flip"] = 0;
  const auto input = OIIO::ImageInput::open(path.string(), &request);
  ASSERT_TRUE(input);
  ASSERT_EQ(input->spec().width, 96);
  ASSERT_EQ(input->spec().height, 64);
  std::vector<std::uint16_t> values(96 * 64);
  ASSERT_TRUE(input->read_image(0, 0, 0, 1, OIIO::TypeDesc::UINT16, values.data()));
  for (std::size_t i = 0; i < values.size(); ++i) ASSERT_EQ(values[i], frame.values.data()[i]) << i;
}

// By definition: one bit after another, the highest first.
TEST(UnpackBits, TakesBitAfterBit) {
  std::mt19937 random(3);
  std::vector<std::uint8_t> bytes(200);
  for (auto& b : bytes) b = static_cast<std::uint8_t>(random());
  for (int bits = 9; bits <= 15; ++bits) {
    std::vector<std::uint16_t> values(101);
    UnpackBits(bytes, bits, values);
    std::size_t at = 0;
    for (std::size_t i = 0; i < values.size(); ++i) {
      unsigned expected = 0;
      for (int k = 0; k < bits; ++k, ++at) expected = 2 * expected + (bytes[at / 8] >> (7 - at % 8) & 1U);
      ASSERT_EQ(values[i], expected) << bits << " bits, value " << i;
    }
  }
}

// LibRaw's own decoder, bit by bit: the same values for any depth and width.
TEST_F(RawFrameFile, UnpacksAsLibRawDoes) {
  const auto bytes = EncodeDng(RandomBayer(96, 64), {});
  // TIFF 6.0: 256 is the width, 258 the bits of a value.
  for (const auto& [tag, value] : {std::pair{258, 12}, {258, 10}, {258, 9}, {256, 95}, {256, 77}}) {
    auto changed = bytes;
    for (std::size_t i = 8; i + 12 < 400; ++i) {
      const auto at = [&](std::size_t k) { return std::to_integer<int>(changed[i + k]); };
      const bool found = at(0) == tag % 256 && at(1) == tag / 256 && (at(2) == 3 || at(2) == 4) &&
                         at(3) == 0 && at(4) == 1 && at(5) == 0;
      if (found) changed[i + 8] = static_cast<std::byte>(value);
    }
    const auto path = Write("packed.dng", changed);
    const BayerFrame frame = ReadBayerFrame(path);
    LibRaw slow;
    ASSERT_EQ(slow.open_file(path.c_str()), LIBRAW_SUCCESS);
    ASSERT_EQ(slow.unpack(), LIBRAW_SUCCESS);
    const auto& sizes = slow.imgdata.sizes;
    ASSERT_TRUE(frame.values.SameShape(sizes.width, sizes.height)) << tag << " " << value;
    if (tag == 256) {
      ASSERT_EQ(sizes.raw_width, value);
    }
    const std::size_t pitch = sizes.raw_pitch / 2;
    for (int y = 0; y < sizes.height; ++y) {
      const auto* row = slow.imgdata.rawdata.raw_image + (y + sizes.top_margin) * pitch + sizes.left_margin;
      ASSERT_TRUE(std::equal(row, row + sizes.width, frame.values.Row(y)))
          << tag << " " << value << " row " << y;
    }
  }
}

// TIFF 6.0, tag 274: how a picture is to be turned when it is shown. The sensor lies as it lies: the same
// values in the same places, under the same filters.
TEST_F(RawFrameFile, HeedsNoOrientationTag) {
  const auto bayer = RandomBayer(96, 64);
  const auto bytes = EncodeDng(bayer, {});
  const std::array<std::byte, 8> entry{std::byte{0x12}, std::byte{1}, std::byte{3}, std::byte{0},
                                       std::byte{1},    std::byte{0}, std::byte{0}, std::byte{0}};
  const auto found = std::search(bytes.begin(), bytes.end(), entry.begin(), entry.end());
  ASSERT_NE(found, bytes.end());
  for (int orientation = 1; orientation <= 8; ++orientation) {
    auto turned = bytes;
    turned[static_cast<std::size_t>(found - bytes.begin()) + entry.size()] =
        static_cast<std::byte>(orientation);
    const BayerFrame frame = ReadBayerFrame(Write("turned.dng", turned));
    ASSERT_TRUE(frame.values.SameShape(bayer)) << orientation;
    EXPECT_TRUE(std::equal(bayer.values().begin(), bayer.values().end(), frame.values.values().begin()))
        << orientation;
    EXPECT_EQ(frame.colours, (std::array<char, 4>{'R', 'G', 'G', 'B'})) << orientation;
  }
}

// By definition: a file cut anywhere is no frame.
TEST_F(RawFrameFile, RefusesATruncatedFile) {
  const auto bytes = EncodeDng(RandomBayer(96, 64), {});
  for (const double share : {0.0, 0.001, 0.02, 0.3, 0.9, 0.999}) {
    const auto length = static_cast<std::size_t>(share * static_cast<double>(bytes.size()));
    const auto path = Write("cut.dng", std::span(bytes).first(length));
    EXPECT_THAT(ErrorOf(path), HasSubstr("cut.dng"))
        << "cut to " << length << " of " << bytes.size() << " bytes";
  }
}

// By definition: no other file passes as a frame, and the message names it.
TEST_F(RawFrameFile, RefusesForeignFilesByName) {
  const std::string text = "This is not a photograph, whatever its name says.\n";
  EXPECT_THAT(ErrorOf(Write("note.dng", std::as_bytes(std::span(text)))), HasSubstr("note.dng"));
  EXPECT_THAT(ErrorOf(folder_ / "missing.dng"), HasSubstr("no such file"));
  std::filesystem::create_directories(folder_ / "folder.dng");
  EXPECT_THAT(ErrorOf(folder_ / "folder.dng"), HasSubstr("folder.dng"));
}

// By definition: whatever bytes are flipped, there is a frame of bounded size or an InputError, nothing else.
TEST_F(RawFrameFile, SurvivesDamagedHeaders) {
  const auto bytes = EncodeDng(RandomBayer(96, 64), {});
  std::mt19937 random(2);
  int refused = 0;
  for (int i = 0; i < 200; ++i) {
    auto damaged = bytes;
    for (int k = 0; k < 3; ++k) damaged[random() % 400] = static_cast<std::byte>(random() & 0xFF);
    const auto path = Write("damaged.dng", damaged);
    try {
      const BayerFrame frame = ReadBayerFrame(path);
      EXPECT_LE(frame.values.size(), 200'000'000u);
    } catch (const InputError&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 20);
}

// Found by raw_frame_fuzz: LibRaw 0.20 overruns a buffer on it, and libc ended the program.
TEST_F(RawFrameFile, RefusesWhatEndsLibRaw) {
  const std::filesystem::path found = DERMAP_FUZZ_FOUND "/raw_hasselblad_model.bin";
  ASSERT_TRUE(std::filesystem::exists(found));
  EXPECT_THAT(ErrorOf(found), HasSubstr("expected a complete raw file"));
}

}  // namespace
}  // namespace dermap
