// SPDX-License-Identifier: Apache-2.0
// The quick decoder of lossless JPEG, against the values that were written. Expected: those values, and ITU-T
// T.81 for what is no such file.
#include "calibrate/lossless_jpeg.h"

#include <gtest/gtest.h>

#include <random>

#include "calibrate/strips.h"
#include "tests/calibrate/jpeg_writer.h"

namespace dermap {
namespace {

std::span<const std::uint8_t> View(const Bytes& bytes) {
  return {reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()};
}

// Small differences mostly, and now and then any value at all.
std::vector<std::uint16_t> Values(const JpegLayout& layout, unsigned seed) {
  std::mt19937 random(seed);
  const unsigned mask = (1U << layout.bits) - 1U;
  std::vector<std::uint16_t> values(
      static_cast<std::size_t>(layout.lines * layout.columns * layout.components));
  for (auto& v : values)
    v = static_cast<std::uint16_t>((random() % 8 == 0 ? random() : mask / 3 + random() % 40) & mask);
  return values;
}

// False where a line was refused.
bool Decodes(const Bytes& file, std::vector<std::uint16_t>& values) {
  auto jpeg = LosslessJpeg::Open(View(file));
  if (!jpeg) return false;
  const auto width = static_cast<std::size_t>(jpeg->values_per_line());
  values.assign(width * static_cast<std::size_t>(jpeg->shape().lines), 0);
  for (std::size_t at = 0; at < values.size(); at += width) {
    if (!jpeg->NextLine(std::span(values).subspan(at, width))) return false;
  }
  return true;
}

TEST(LosslessJpeg, GivesBackWhatWasWritten) {
  for (const int components : {1, 2, 4}) {
    for (const int bits : {8, 12, 14, 16}) {
      for (const int columns : {1, 3, 50}) {
        const JpegLayout layout{20, columns, components, bits};
        const auto written = Values(layout, static_cast<unsigned>(bits));
        std::vector<std::vector<JpegCode>> codes{{CodeOfFiveBits()}, {ShortestCode(written, layout)}};
        if (bits <= 14) codes.push_back({CodeOfGrowingLength()});
        if (components == 2) codes.push_back({CodeOfFiveBits(), ShortestCode(written, layout)});
        for (std::size_t k = 0; k < codes.size(); ++k) {
          std::vector<std::uint16_t> read;
          ASSERT_TRUE(Decodes(EncodeLosslessJpeg(written, layout, codes[k]), read))
              << components << " components, " << bits << " bits, " << columns << " columns, code " << k;
          EXPECT_EQ(read, written) << components << " components, " << bits << " bits, " << columns
                                   << " columns, code " << k;
        }
      }
    }
  }
}

// T.81 H.1.2.2: the difference of 32768 has a category of its own and no bits.
TEST(LosslessJpeg, KnowsTheLargestDifference) {
  const JpegLayout layout{1, 4, 1, 16};
  const std::vector<std::uint16_t> written{0, 32768, 0, 65535};
  std::vector<std::uint16_t> read;
  ASSERT_TRUE(Decodes(EncodeLosslessJpeg(written, layout, {CodeOfFiveBits()}), read));
  EXPECT_EQ(read, written);
}

// By definition: data cut anywhere, or a value beyond the depth, is no frame.
TEST(LosslessJpeg, TellsDamage) {
  const JpegLayout layout{12, 30, 2, 12};
  const auto values = Values(layout, 5);
  const Bytes whole = EncodeLosslessJpeg(values, layout, {ShortestCode(values, layout)});
  std::vector<std::uint16_t> read;
  ASSERT_TRUE(Decodes(whole, read));
  // The last two bytes are the mark of the end.
  for (std::size_t length = 0; length + 2 < whole.size(); ++length) {
    EXPECT_FALSE(Decodes(Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(length)), read))
        << length;
  }
  auto deeper = values;
  deeper[200] = 4096;
  EXPECT_FALSE(Decodes(EncodeLosslessJpeg(deeper, layout, {CodeOfFiveBits()}), read));
  // Five bits of ones are none of the 17 codes.
  Bytes no_code = EncodeLosslessJpeg(values, layout, {CodeOfFiveBits()});
  for (std::size_t i = no_code.size() / 2; i < no_code.size() / 2 + 8; i += 2)
    no_code[i] = std::byte{0xFF}, no_code[i + 1] = std::byte{0};
  EXPECT_FALSE(Decodes(no_code, read));
}

// T.81 B.2: other predictors, cut-off bits, restart markers and scaled components are JPEG too, but not of
// this kind.
TEST(LosslessJpeg, LeavesOtherKindsToOthers) {
  const JpegLayout layout{4, 4, 2, 12};
  const Bytes file = EncodeLosslessJpeg(Values(layout, 1), layout, {CodeOfFiveBits()});
  ASSERT_TRUE(LosslessJpeg::Open(View(file)));
  const std::size_t frame = 2 + 2 + 2 + 17 + 17;  // behind the start and the table
  const std::size_t scan = frame + 2 + 2 + 6 + 6;
  ASSERT_EQ(file[frame + 1], std::byte{0xC3});
  ASSERT_EQ(file[scan + 1], std::byte{0xDA});
  const auto refused = [&](std::size_t at, int value) {
    Bytes changed = file;
    changed[at] = static_cast<std::byte>(value);
    return !LosslessJpeg::Open(View(changed));
  };
  EXPECT_TRUE(refused(scan + 9, 4));         // predictor
  EXPECT_TRUE(refused(scan + 11, 1));        // one bit cut off
  EXPECT_TRUE(refused(scan + 6, 0x20));      // a table that is not there
  EXPECT_TRUE(refused(frame + 1, 0xC0));     // lossy
  EXPECT_TRUE(refused(frame + 9, 3));        // components
  EXPECT_TRUE(refused(frame + 11, 0x21));    // scaled
  EXPECT_TRUE(refused(frame + 4, 17));       // bits
  EXPECT_TRUE(refused(4 + 2 + 1, 3));        // three codes of one bit
  EXPECT_TRUE(refused(4 + 2 + 1 + 16, 17));  // a category beyond the last
  Bytes restarting = file;
  const Bytes interval{std::byte{0xFF}, std::byte{0xDD}, std::byte{0},
                       std::byte{4},    std::byte{0},    std::byte{2}};
  restarting.insert(restarting.begin() + static_cast<std::ptrdiff_t>(scan), interval.begin(), interval.end());
  EXPECT_FALSE(LosslessJpeg::Open(View(restarting)));
}

// By hand: strips of 3, 3 and 2 photosites, 2 high, out of 4 lines of 4 values.
TEST(Strips, StandSideBySide) {
  const JpegLayout layout{4, 4, 1, 8};
  std::vector<std::uint16_t> values(16);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<std::uint16_t>(i);
  const Bytes file = EncodeLosslessJpeg(values, layout, {CodeOfFiveBits()});
  auto jpeg = LosslessJpeg::Open(View(file));
  ASSERT_TRUE(jpeg);
  EXPECT_FALSE(Fills(*jpeg, {3, 3, 3, 2}));
  EXPECT_FALSE(Fills(*jpeg, {0, 3, 2, 2}));
  const StripLayout strips{3, 3, 2, 2};
  ASSERT_TRUE(Fills(*jpeg, strips));
  std::vector<std::uint16_t> frame(18, 99);  // rows of 9, the last value of each is no photosite
  ASSERT_TRUE(DecodeStrips(*jpeg, strips, 9, frame.data()));
  EXPECT_EQ(frame,
            (std::vector<std::uint16_t>{0, 1, 2, 6, 7, 8, 12, 13, 99, 3, 4, 5, 9, 10, 11, 14, 15, 99}));
}

}  // namespace
}  // namespace dermap
