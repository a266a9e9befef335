// SPDX-License-Identifier: Apache-2.0
// A session stopped at any point and resumed must be the session that was never stopped: that is the truth
// here.
#include "acquire/sequence.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "acquire/schedule.h"
#include "acquire/simulated/dng_writer.h"
#include "acquire/simulated/simulated_station.h"
#include "common/core/error.h"
#include "common/files/atomic_file.h"
#include "common/files/session_journal.h"
#include "tests/acquire/support.h"

namespace dermap {
namespace {

namespace fs = std::filesystem;
using acquire_test::kSmallPlanFrames;
using acquire_test::TemporaryFolder;
using acquire_test::WatchedStation;
using testing::HasSubstr;

class Sequence : public testing::Test {
 protected:
  Sequence() {
    folder_.Write("scene.toml", acquire_test::SmallSceneToml());
    options_.rig = folder_.Write("rig.toml", acquire_test::SmallRigToml("scene.toml"));
    options_.plan = folder_.Write("plan.toml", acquire_test::SmallPlanToml());
    options_.out = folder_.path() / "session";
  }

  // Hash of every frame of a session that nothing disturbs.
  std::vector<std::string> Undisturbed() {
    CaptureOptions options = options_;
    options.out = folder_.path() / "undisturbed";
    std::vector<std::string> hashes;
    for (const FrameRecord& f : RunCapture(options).session.frames) hashes.push_back(f.sha256);
    return hashes;
  }

  void ExpectWhole(const std::vector<std::string>& hashes) {
    const Session session = ReadSession(options_.out);
    EXPECT_TRUE(session.complete);
    ASSERT_EQ(session.frames.size(), hashes.size());
    for (std::size_t i = 0; i < hashes.size(); ++i) EXPECT_EQ(session.frames[i].sha256, hashes[i]) << i;
    VerifyFrames(session);
    // Nothing else lies in frames/: no temporary file, no second copy.
    const auto files =
        std::distance(fs::directory_iterator(options_.out / "frames"), fs::directory_iterator{});
    EXPECT_EQ(files, static_cast<std::ptrdiff_t>(hashes.size()));
  }

  template <class Exception>
  std::string MessageOf(const CaptureOptions& options) {
    try {
      RunCapture(options);
    } catch (const Exception& e) {
      return e.what();
    }
    return "no error";
  }

  TemporaryFolder folder_;
  CaptureOptions options_;
};

// The plan by hand: a black frame for each of two ISO, then two filters on Spectralon, then on skin.
TEST_F(Sequence, TakesWhatThePlanAsksForInOrder) {
  std::vector<std::string> files;
  int warnings = 0;
  std::vector<double> fractions;
  options_.on_frame = [&](const FrameEvent& e, const RawFrame&) {
    files.push_back(e.frame.file);
    warnings += !e.warning.empty();
    EXPECT_TRUE(fs::exists(options_.out / e.frame.file));
    EXPECT_EQ(e.check.width_px, 96);
    EXPECT_EQ(e.done, static_cast<int>(files.size()));
  };
  options_.progress = [&](double f) { fractions.push_back(f); };
  const CaptureSummary summary = RunCapture(options_);
  EXPECT_THAT(files,
              testing::ElementsAre("frames/0001_black_0nm.dng", "frames/0002_black_0nm.dng",
                                   "frames/0003_spectralon_540nm.dng", "frames/0004_spectralon_650nm.dng",
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

// The camera dies before each frame in turn.
TEST_F(Sequence, ResumesAfterADeviceFailureAtEveryFrame) {
  const auto hashes = Undisturbed();
  for (int dies_at = 1; dies_at <= kSmallPlanFrames; ++dies_at) {
    fs::remove_all(options_.out);
    options_.resume = false;
    SimulatedStation inner(ReadRig(options_.rig));
    WatchedStation station(inner);
    station.before_capture = [&](const CaptureSettings& s) {
      if (s.shot == dies_at) throw DeviceError("unplugged");
    };
    EXPECT_THROW(RunCapture(options_, station), DeviceError);
    if (dies_at > 1) {
      EXPECT_FALSE(ReadSession(options_.out).complete);
    }
    station.before_capture = nullptr;
    options_.resume = true;
    const CaptureSummary summary = RunCapture(options_, station);
    EXPECT_EQ(summary.kept, dies_at - 1);
    EXPECT_EQ(summary.taken, kSmallPlanFrames - dies_at + 1);
    for (const auto& [shot, times] : station.shots) EXPECT_EQ(times, shot == dies_at ? 2 : 1) << shot;
    ExpectWhole(hashes);
  }
}

// Power cut: the journal ends anywhere, in the middle of a line too, and the manifest is from before or
// missing.
TEST_F(Sequence, ResumesAfterTruncationOfTheJournalAnywhere) {
  const auto hashes = Undisturbed();
  RunCapture(options_);
  const std::string journal = ReadTextFile(options_.out / "journal.jsonl");
  options_.resume = true;
  for (std::size_t length = 0; length < journal.size(); length += 151) {
    std::ofstream(options_.out / "journal.jsonl", std::ios::trunc) << journal.substr(0, length);
    fs::remove(options_.out / "session.json");
    const auto lines =
        std::count(journal.begin(), journal.begin() + static_cast<std::ptrdiff_t>(length), '\n');
    const CaptureSummary summary = RunCapture(options_);
    EXPECT_EQ(summary.kept, std::clamp<int>(static_cast<int>(lines) - 1, 0, kSmallPlanFrames)) << length;
    EXPECT_EQ(summary.kept + summary.taken, kSmallPlanFrames);
    ExpectWhole(hashes);
  }
}

TEST_F(Sequence, TakesDamagedAndMissingFramesAgain) {
  const auto hashes = Undisturbed();
  RunCapture(options_);
  fs::remove(options_.out / "frames/0003_spectralon_540nm.dng");
  fs::resize_file(options_.out / "frames/0006_skin_650nm.dng", 1000);
  options_.resume = true;
  const CaptureSummary summary = RunCapture(options_);
  EXPECT_EQ(summary.kept, kSmallPlanFrames - 2);
  EXPECT_EQ(summary.taken, 2);
  ExpectWhole(hashes);
  // A session that is whole already is left as it is.
  const std::string journal = ReadTextFile(options_.out / "journal.jsonl");
  EXPECT_EQ(RunCapture(options_).taken, 0);
  EXPECT_EQ(ReadTextFile(options_.out / "journal.jsonl"), journal);
}

// A frame that lay in the camera's memory comes as .cr2, taken again from its card as .dng: one file stays.
// What a kill has left half-written goes as well, and nothing else.
TEST_F(Sequence, LeavesNoFileOfNoFrameBehind) {
  const auto hashes = Undisturbed();
  SimulatedStation inner(ReadRig(options_.rig));
  WatchedStation station(inner);
  station.after_capture = [&](const CaptureSettings& s, RawFrame& frame) {
    if (s.shot == 3 && station.shots[3] == 1) frame.extension = ".cr2";
  };
  bool asked = false;
  options_.retake = [&]() -> std::optional<int> {
    if (asked || station.shots[5] == 0) return std::nullopt;
    asked = true;
    return 3;
  };
  RunCapture(options_, station);
  EXPECT_EQ(station.shots[3], 2);
  ExpectWhole(hashes);

  options_.retake = nullptr;
  options_.resume = true;
  std::ofstream(options_.out / "frames/0004_spectralon_650nm.cr2") << "killed before the journal told of it";
  std::ofstream(options_.out / "frames/.0005_skin_540nm.partial-77-0.dng") << "killed in the middle";
  std::ofstream(options_.out / "frames/notes.txt") << "of the operator";
  RunCapture(options_, station);
  EXPECT_TRUE(fs::remove(options_.out / "frames/notes.txt"));
  ExpectWhole(hashes);
}

// A transfer that is cut short is noticed while the subject is there, and the frame taken again.
TEST_F(Sequence, RetakesAFrameThatDoesNotDecode) {
  const auto hashes = Undisturbed();
  SimulatedStation inner(ReadRig(options_.rig));
  WatchedStation station(inner);
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

TEST_F(Sequence, StopsBetweenFramesWhenAsked) {
  int asked = 0;
  options_.stop = [&] { return ++asked > 3; };
  const CaptureSummary summary = RunCapture(options_);
  EXPECT_FALSE(summary.session.complete);
  EXPECT_EQ(summary.taken, 3);
  options_.stop = nullptr;
  options_.resume = true;
  EXPECT_EQ(RunCapture(options_).kept, 3);
}

// A full disk, as the system tells of it: no file may grow beyond 8 kB, a frame has 10 kB.
TEST_F(Sequence, FullDiskIsAStorageErrorAndCanBeResumed) {
  const auto hashes = Undisturbed();
  SimulatedStation inner(ReadRig(options_.rig));
  WatchedStation station(inner);
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  const auto ignored = signal(SIGXFSZ, SIG_IGN);
  station.before_capture = [&](const CaptureSettings& s) {
    rlimit small = before;
    small.rlim_cur = 8192;
    if (s.shot == 4) setrlimit(RLIMIT_FSIZE, &small);
  };
  EXPECT_THROW(RunCapture(options_, station), StorageError);
  setrlimit(RLIMIT_FSIZE, &before);
  signal(SIGXFSZ, ignored);
  EXPECT_FALSE(fs::exists(options_.out / "frames/0004_spectralon_650nm.dng"));
  station.before_capture = nullptr;
  options_.resume = true;
  // Frame 3 was on its way to the disk while frame 4 was exposed: it is there as a whole, or not at all.
  const auto files = std::distance(fs::directory_iterator(options_.out / "frames"), fs::directory_iterator{});
  EXPECT_GE(files, 2);
  EXPECT_EQ(RunCapture(options_, station).kept, files);
  ExpectWhole(hashes);
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
  other.plan = folder_.Write("other.toml", acquire_test::SmallPlanToml() + "");
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
  other.rig = folder_.Write(
      "r.toml", "[camera]\ndriver = \"polaroid\"\n" + acquire_test::SmallRigToml("scene.toml").substr(15));
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
  folder_.Write("scene.toml", acquire_test::SmallSceneToml() + "misfired_shots = [6]\n");
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

// A plan that saturates the filter in slot 1 and underexposes the one in slot 2. The small plan has both
// right.
class AdaptedSequence : public Sequence {
 protected:
  AdaptedSequence() {
    options_.plan = folder_.Write("wrong.toml",
                                  "[[exposure]]\nslot = 1\niso = 1600\n[[exposure]]\nslot = 2\niso = 100\n");
    options_.on_frame = [this](const FrameEvent& event, const RawFrame&) {
      order_.push_back(event.frame.role);
      if (event.frame.role != FrameRole::kBlack) saturated_ += event.check.saturated_share > 0.001;
    };
  }
  // Every lit frame has a black frame of its own setting; bands are taken at one ISO.
  static void ExpectBalanced(const Session& session) {
    std::map<int, std::set<int>> isos;
    std::set<int> black;
    for (const FrameRecord& f : session.frames) {
      if (f.role == FrameRole::kBlack) black.insert(f.iso);
    }
    for (const FrameRecord& f : session.frames) {
      if (f.role == FrameRole::kBlack) continue;
      isos[f.slot].insert(f.iso);
      EXPECT_EQ(black.count(f.iso), 1u) << "ISO " << f.iso;
    }
    for (const auto& [slot, used] : isos) EXPECT_EQ(used.size(), 1u) << "slot " << slot;
  }
  std::vector<FrameRole> order_;
  int saturated_ = 0;
};

TEST_F(AdaptedSequence, ChangesTheIsoOfWhatIsTooBrightOrTooDarkBeforeTheSkinIsThere) {
  const CaptureSummary summary = RunCapture(options_);
  const Session session = ReadSession(options_.out);
  EXPECT_TRUE(session.complete);
  EXPECT_EQ(saturated_, 0);
  // Slot 1 by a stop, by a stop, and then, as the card tells how far, to the end; slot 2 in one step. Which
  // slot comes first depends on how soon a frame is decoded.
  std::map<int, std::vector<ExposureChange>> changes;
  for (const ExposureChange& change : session.exposure_changes) changes[change.slot].push_back(change);
  ASSERT_EQ(changes[1].size(), 3u);
  EXPECT_EQ(changes[1][0].from_iso, 1600);
  EXPECT_EQ(changes[1][0].to_iso, 800);
  EXPECT_EQ(changes[1][2].to_iso, 100);
  EXPECT_THAT(changes[1][2].why, HasSubstr("saturated"));
  ASSERT_EQ(changes[2].size(), 1u);
  EXPECT_EQ(changes[2][0].from_iso, 100);
  EXPECT_EQ(changes[2][0].to_iso, 200);
  EXPECT_THAT(changes[2][0].why, HasSubstr("of the range"));
  // The plan's black frames at ISO 100 and 1600, and one at ISO 200 between Spectralon and skin.
  EXPECT_EQ(summary.total, 7);
  using enum FrameRole;
  EXPECT_THAT(order_, testing::ElementsAre(kBlack, kBlack, kSpectralon, kSpectralon, kBlack, kSkin, kSkin));
  ExpectBalanced(session);
  VerifyFrames(session);
  EXPECT_EQ(session.plan.exposures[0].iso, 1600) << "the plan stays what was asked for";
}

// A weak flash is not the filter's fault: the next frame is fine, and nothing is changed.
TEST_F(AdaptedSequence, DoesNotRaiseTheIsoForOneWeakFlash) {
  options_.plan = folder_.path() / "plan.toml";
  SimulatedStation inner(ReadRig(options_.rig));
  WatchedStation station(inner);
  station.after_capture = [&](const CaptureSettings& s, RawFrame& frame) {
    if (s.shot != 3 || station.shots[3] != 1) return;
    SimulatedStation dim(ReadRig(options_.rig));  // an eighth of the light: at an eighth of the ISO's gain
    dim.Place(FrameRole::kSpectralon);
    dim.wheel().MoveTo(1);
    Plane<std::uint16_t> weak = dim.bench().Expose({FrameRole::kSpectralon, 1, 10.0, 100, 3});
    for (auto& v : weak.values()) v = static_cast<std::uint16_t>(126 + (std::max<int>(v, 126) - 126) / 8);
    frame.bytes = EncodeDng(weak, MetadataOfShot(dim.bench(), {FrameRole::kSpectralon, 1, 10.0, 100, 3}));
  };
  const CaptureSummary summary = RunCapture(options_, station);
  EXPECT_EQ(station.shots[3], 2);
  EXPECT_TRUE(summary.session.exposure_changes.empty());
  EXPECT_EQ(summary.session.frames.size(), static_cast<std::size_t>(kSmallPlanFrames));
}

// Stopped before each shot, so also between a change and its black frames, and resumed.
TEST_F(AdaptedSequence, IsTheSameSessionWhereverItWasInterrupted) {
  std::vector<std::string> hashes;
  for (const FrameRecord& f : RunCapture(options_).session.frames) hashes.push_back(f.sha256);
  const int exposures = static_cast<int>(RunCapture([&] {
                                           CaptureOptions o = options_;
                                           o.out = folder_.path() / "again";
                                           return o;
                                         }())
                                             .timeline.frames.size());
  ASSERT_EQ(exposures, 7 + 3 + 2);  // frames, saturated ones, underexposed ones
  for (int dies_at = 1; dies_at <= exposures; ++dies_at) {
    fs::remove_all(options_.out);
    options_.resume = false;
    SimulatedStation inner(ReadRig(options_.rig));
    WatchedStation station(inner);
    int taken = 0;
    station.before_capture = [&](const CaptureSettings&) {
      if (++taken == dies_at) throw DeviceError("unplugged");
    };
    EXPECT_THROW(RunCapture(options_, station), DeviceError) << dies_at;
    station.before_capture = nullptr;
    options_.resume = true;
    EXPECT_TRUE(RunCapture(options_, station).session.complete);
    ExpectWhole(hashes);
    ExpectBalanced(ReadSession(options_.out));
  }
}

TEST_F(AdaptedSequence, HandsItsChangesToASessionThatTakesItsSpectralonOver) {
  RunCapture(options_);
  CaptureOptions second = options_;
  second.out = folder_.path() / "second";
  second.reference = options_.out;
  const CaptureSummary summary = RunCapture(second);
  EXPECT_EQ(summary.from_reference, 5);
  EXPECT_EQ(summary.taken, 2);
  ExpectBalanced(summary.session);
}

// Skin that shines where Spectralon does not: only its own frames change.
TEST_F(AdaptedSequence, ChangesSkinAloneWhereSpectralonIsRight) {
  options_.plan = folder_.path() / "plan.toml";
  SimulatedStation inner(ReadRig(options_.rig));
  WatchedStation station(inner);
  station.after_capture = [&](const CaptureSettings& s, RawFrame& frame) {
    if (s.shot != 6 || s.iso != 250) return;
    auto bayer = inner.bench().Expose({FrameRole::kSkin, 2, 10.0, 250, 6});
    for (int i = 0; i < 96; ++i) bayer(i, 40) = 4095;
    frame.bytes = EncodeDng(bayer, MetadataOfShot(inner.bench(), {FrameRole::kSkin, 2, 10.0, 250, 6}));
  };
  const Session session = RunCapture(options_, station).session;
  ASSERT_EQ(session.exposure_changes.size(), 1u);
  EXPECT_EQ(session.exposure_changes[0].role, FrameRole::kSkin);
  EXPECT_EQ(session.frames[3].iso, 250);  // Spectralon of slot 2
  EXPECT_EQ(session.frames[5].iso, 125);
  EXPECT_EQ(session.frames[6].role, FrameRole::kBlack);
  EXPECT_EQ(session.frames[6].iso, 125);
}

}  // namespace
}  // namespace dermap
