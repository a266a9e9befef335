// SPDX-License-Identifier: Apache-2.0
// Damaged files are noticed, and exposure is told right.
#include "acquire/frame_check.h"

#include <gtest/gtest.h>

#include "acquire/simulated/dng_writer.h"
#include "common/files/atomic_file.h"

namespace dermap {
namespace {

// Three quarters of the photosites at 1118 DN, one quarter at the white level; by hand: a quarter is
// saturated.
RawFrame QuarterSaturated() {
  Plane<std::uint16_t> bayer(64, 48, 1118);
  for (int y = 0; y < 48; ++y) {
    for (int x = 0; x < 16; ++x) bayer(x, y) = 4095;
  }
  return {EncodeDng(bayer, {}), ".dng"};
}

TEST(FrameCheck, TellsSizeAndExposure) {
  const FrameCheck check = CheckFrame(QuarterSaturated());
  EXPECT_TRUE(check.decodes) << check.problem;
  EXPECT_EQ(check.size.width_px, 64);
  EXPECT_EQ(check.size.height_px, 48);
  EXPECT_DOUBLE_EQ(check.saturated_share, 0.25);
  EXPECT_DOUBLE_EQ(check.level, 1.0);

  // (1118 - 126) / (4095 - 126)
  EXPECT_NEAR(CheckFrame({EncodeDng(Plane<std::uint16_t>(64, 48, 1118), {}), ".dng"}).level, 0.24994, 1e-5);
}

// Every length but the whole one is a damaged file.
TEST(FrameCheck, NoticesTruncationAtAnyLength) {
  const RawFrame whole = QuarterSaturated();
  ASSERT_TRUE(CheckFrame(whole).decodes);
  for (std::size_t length = 0; length < whole.bytes.size(); length += length < 1000 ? 37 : 211) {
    RawFrame cut = whole;
    cut.bytes.resize(length);
    const FrameCheck check = CheckFrame(cut);
    EXPECT_FALSE(check.decodes) << length << " of " << whole.bytes.size();
    EXPECT_FALSE(check.problem.empty());
  }
}

// Found by raw_frame_fuzz: LibRaw 0.20 overruns a buffer on it, and libc ended the program.
TEST(FrameCheck, SurvivesWhatEndsLibRaw) {
  const std::string bytes = ReadTextFile(DERMAP_FUZZ_FOUND "/raw_hasselblad_model.bin");
  const auto* data = reinterpret_cast<const std::byte*>(bytes.data());
  const FrameCheck check = CheckFrame({{data, data + bytes.size()}, ".dng"});
  EXPECT_FALSE(check.decodes);
  EXPECT_EQ(check.problem, "is damaged where it names its camera");
}

TEST(FrameCheck, RefusesWhatIsNoRawFile) {
  EXPECT_FALSE(CheckFrame({std::vector<std::byte>(5000, std::byte{0x55}), ".dng"}).decodes);
}

}  // namespace
}  // namespace dermap
