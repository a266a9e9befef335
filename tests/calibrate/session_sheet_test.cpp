// SPDX-License-Identifier: Apache-2.0
// The picture of a session as found: by construction, one file is gone, one cut short, one another's, one
// filter never taken.
#include "calibrate/session_sheet.h"

#include <gtest/gtest.h>

#include <stdexcept>

#include "acquire/simulated/dng_writer.h"
#include "common/files/atomic_file.h"
#include "tests/calibrate/simulated_session.h"
#include "tests/common/files/temporary_folder.h"

namespace dermap {
namespace {

class SessionSheetTest : public ::testing::Test {
 protected:
  SessionSheetTest()
      : simulated_("gray_50.toml", {}, [](PlanConfig& plan) { plan.exposures.resize(2); }),
        session_(simulated_.session()) {
    session_.directory = folder_.path();
    for (FrameRecord& frame : session_.frames) {
      frame.file = "frame" + std::to_string(frame.number) + ".dng";
      const auto bytes = EncodeDng(simulated_.bench().Expose(simulated_.ShotOf(frame)), {});
      WriteFileAtomically(session_.directory / frame.file, bytes);
      frame.sha256 = Sha256(bytes);
    }
  }
  const FrameRecord& Any(FrameRole role, std::size_t i = 0) {
    for (const FrameRecord& frame : session_.frames) {
      if (frame.role == role && i-- == 0) return frame;
    }
    throw std::logic_error("no such frame");
  }
  // Share of the picture in the red that marks a tile.
  double Red(const SessionSheet& sheet) const {
    double red = 0.0;
    for (const Rgb8& c : sheet.picture.values()) red += c[0] > 100 && c[1] < 60 && c[2] < 60 ? 1.0 : 0.0;
    return red / static_cast<double>(sheet.picture.size());
  }

  TemporaryFolder folder_;
  SimulatedSession simulated_;
  Session session_;
};

TEST_F(SessionSheetTest, OfAGoodSessionHasNothingInRed) {
  const SessionSheet sheet = DrawSessionSheet(session_);
  EXPECT_EQ(sheet.bad, 0);
  EXPECT_EQ(Red(sheet), 0.0);
  EXPECT_FALSE(LacksFrames(session_));
}

TEST_F(SessionSheetTest, MarksWhatIsMissingCutShortOrAnotherFile) {
  const std::string skin = Any(FrameRole::kSkin).file, white = Any(FrameRole::kSpectralon).file;
  std::filesystem::remove(folder_.path() / skin);
  SessionSheet sheet = DrawSessionSheet(session_);
  EXPECT_EQ(sheet.bad, 1);
  EXPECT_GT(Red(sheet), 0.02);  // one of at most fifteen tiles, its letters and frame apart
  std::filesystem::resize_file(folder_.path() / white, 100000);
  EXPECT_EQ(DrawSessionSheet(session_).bad, 2);
  std::filesystem::copy_file(folder_.path() / Any(FrameRole::kSkin, 1).file,
                             folder_.path() / Any(FrameRole::kSpectralon, 1).file,
                             std::filesystem::copy_options::overwrite_existing);
  EXPECT_EQ(DrawSessionSheet(session_).bad, 3);
  EXPECT_FALSE(LacksFrames(session_));  // files are not there, but their records are
}

TEST_F(SessionSheetTest, MarksAFilterOfThePlanThatWasNeverTaken) {
  const FrameRecord lost = Any(FrameRole::kSkin, 1);
  std::erase_if(session_.frames, [&](const FrameRecord& f) { return f.number == lost.number; });
  EXPECT_EQ(DrawSessionSheet(session_).bad, 1);
  EXPECT_TRUE(LacksFrames(session_));
}

}  // namespace
}  // namespace dermap
