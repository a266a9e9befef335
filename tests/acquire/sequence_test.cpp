// SPDX-License-Identifier: Apache-2.0
// A session that nothing interrupts: what it takes, what it takes again, and what it refuses.

#include <fstream>

#include "acquire/simulated/dng_writer.h"
#include "common/files/atomic_file.h"
#include "tests/acquire/sequence_fixture.h"

namespace dermap::acquire_test {
namespace {

// The plan by hand: a black frame for each of two ISO, two filters on Spectralon, then on skin. The second
// black frame comes where the wheel passes the opaque slot.
TEST_F(Sequence, TakesWhatThePlanAsksForInOrder) {
  std::vector<std::string> files;
  int warnings = 0;
  std::vector<double> fractions;
  options_.on_frame = [&](const FrameEvent& e, const RawFrame&) {
    files.push_back(e.frame.file);
    warnings += !e.warning.empty();
    EXPECT_TRUE(fs::exists(options_.out / e.frame.file));
    EXPECT_EQ(e.check.size.width_px, 96);
    EXPECT_EQ(e.done, static_cast<int>(files.size()));
  };
  options_.progress = [&](double f) { fractions.push_back(f); };
  const CaptureSummary summary = RunCapture(options_);
  EXPECT_THAT(files, testing::ElementsAre("frames/0001_black_0nm.dng", "frames/0003_spectralon_540nm.dng",
                                          "frames/0004_spectralon_650nm.dng", "frames/0002_black_0nm.dng",
                                          "frames/0005_skin_540nm.dng", "frames/0006_skin_650nm.dng"));
  EXPECT_EQ(summary.taken, kSmallPlanFrames);
  EXPECT_EQ(summary.kept, 0);
  EXPECT_TRUE(summary.session.complete);
  EXPECT_EQ(warnings, 0);
  EXPECT_TRUE(std::is_sorted(fractions.begin(), fractions.end()));
  EXPECT_EQ(fractions.back(), 1.0);
  EXPECT_TRUE(fs::exists(options_.out / "truth/reflectance.exr"));
  EXPECT_TRUE(fs::exists(options_.out / "truth/bench.json"));
  const Session session = ReadSession(options_.out);
  EXPECT_EQ(session.frames[0].iso, 100);
  EXPECT_EQ(session.frames[1].iso, 250);
  EXPECT_EQ(session.frames[5].iso, 250);
  VerifyFrames(session);
}

TEST_F(Sequence, SameSeedGivesTheSameBytes) {
  const auto hashes = Undisturbed();
  RunCapture(options_);
  ExpectWhole(hashes);
}

// A transfer that is cut short is noticed while the subject is there, and the frame taken again.
TEST_F(Sequence, RetakesAFrameThatDoesNotDecode) {
  const auto hashes = Undisturbed();
  WatchedStation& station = Watch();
  station.after_capture = [&](const CaptureSettings& s, RawFrame& frame) {
    if (s.shot == 5 && station.shots[5] == 1) frame.bytes.resize(frame.bytes.size() / 2);
    if (s.shot == 6 && station.shots[6] == 1) frame.bytes.assign(100, std::byte{'x'});
  };
  RunCapture(options_, station);
  EXPECT_EQ(station.shots[4], 1);
  EXPECT_EQ(station.shots[5], 2);
  EXPECT_EQ(station.shots[6], 2);
  ExpectWhole(hashes);

  fs::remove_all(options_.out);
  station.after_capture = [&](const CaptureSettings&, RawFrame& frame) { frame.bytes.clear(); };
  EXPECT_THROW(RunCapture(options_, station), DeviceError);
  EXPECT_TRUE(!fs::exists(options_.out / "frames") || fs::is_empty(options_.out / "frames"));
}

// Somebody has set the camera to smaller raw files, as the file itself tells; what is right is known from
// what an earlier run has taken.
TEST_F(Sequence, RetakesAFrameOfAnotherSize) {
  const auto hashes = Undisturbed();
  options_.stop = [asked = 0]() mutable { return ++asked > 1; };
  EXPECT_EQ(RunCapture(options_).taken, 1);
  options_.stop = nullptr;
  options_.resume = true;
  WatchedStation& station = Watch();
  station.after_capture = [&](const CaptureSettings& s, RawFrame& frame) {
    if (s.shot == 3 && station.shots[3] == 1) frame.bytes = EncodeDng(Plane<std::uint16_t>(48, 36, 1118), {});
  };
  RunCapture(options_, station);
  EXPECT_EQ(station.shots[3], 2);
  EXPECT_EQ(station.shots[4], 1);
  ExpectWhole(hashes);
  EXPECT_THAT(ReadTextFile(options_.out / "journal.jsonl"), HasSubstr("is 48 x 36 in place of 96 x 72"));
}

TEST_F(Sequence, RefusesWhatDoesNotFit) {
  EXPECT_THAT(MessageOf<InputError>([&] {
                auto o = options_;
                o.resume = true;
                return o;
              }()),
              HasSubstr("leave out --resume"));
  RunCapture(options_);
  EXPECT_THAT(MessageOf<InputError>(options_), HasSubstr("--resume"));

  CaptureOptions other = options_;
  other.resume = true;
  other.plan = folder_.Write("other.toml", SmallPlanToml() + "");
  EXPECT_EQ(RunCapture(other).taken, 0);  // the same plan under another name is the same plan
  other.plan = folder_.Write("other.toml", "[[exposure]]\nslot = 2\niso = 100\n");
  EXPECT_THAT(MessageOf<InputError>(other), HasSubstr("another plan"));
  other.plan = options_.plan;
  other.scene = folder_.Write("other_scene.toml", "flat_reflectance = 0.3\n");
  EXPECT_THAT(MessageOf<InputError>(other), HasSubstr("another plan, rig or scene"));

  other = options_;
  other.out = folder_.path() / "new";
  other.plan = folder_.Write("other.toml", "[[exposure]]\nslot = 7\niso = 100\n");
  EXPECT_THAT(MessageOf<InputError>(other), HasSubstr("slot 7"));
  other.plan = options_.plan;
  other.reference = folder_.path();  // no session lies there
  EXPECT_THAT(MessageOf<InputError>(other), HasSubstr("session.json"));
  other.reference.clear();
  other.scene = "no_such_scene.toml";
  EXPECT_THAT(MessageOf<InputError>(other), HasSubstr("no_such_scene.toml"));
  other.scene.clear();
  other.rig =
      folder_.Write("r.toml", "[camera]\ndriver = \"polaroid\"\n" + SmallRigToml("scene.toml").substr(15));
  EXPECT_THAT(MessageOf<InputError>(other), HasSubstr("known: \"simulated\""));
  EXPECT_FALSE(fs::exists(other.out)) << "a session was begun";
}

TEST_F(Sequence, LeavesAFolderOfOtherThingsAlone) {
  fs::create_directories(options_.out);
  std::ofstream(options_.out / "thesis.txt") << "do not lose";
  EXPECT_THAT(MessageOf<InputError>(options_), HasSubstr("not an empty folder"));
  EXPECT_FALSE(fs::exists(options_.out / "journal.jsonl"));
}

// ISO 6400 saturates Spectralon; a flash that does not fire leaves the frame dark.
TEST_F(Sequence, WarnsAboutExposure) {
  folder_.Write("scene.toml", SmallSceneToml() + "misfired_shots = [6]\n");
  options_.plan = folder_.Write("bright.toml",
                                "adapt_exposure = false\n[[exposure]]\nslot = 1\niso = 6400\n"
                                "[[exposure]]\nslot = 2\niso = 250\n");
  const CaptureSummary summary = RunCapture(options_);
  ASSERT_EQ(summary.warnings.size(), 3u);
  EXPECT_THAT(summary.warnings[0], HasSubstr("frame 3 (spectralon, 540 nm)"));
  EXPECT_THAT(summary.warnings[0], HasSubstr("take slot 1 at ISO 3200 in the plan"));
  EXPECT_THAT(summary.warnings[2], HasSubstr("frame 6 (skin, 650 nm) is dark"));
  EXPECT_TRUE(summary.session.exposure_changes.empty());
}

}  // namespace
}  // namespace dermap::acquire_test
