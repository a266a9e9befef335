// SPDX-License-Identifier: Apache-2.0
// A session stopped at any point and resumed must be the session that was never stopped: that is the truth
// here.
#include <signal.h>
#include <sys/resource.h>

#include <array>
#include <fstream>

#include "common/files/atomic_file.h"
#include "tests/acquire/sequence_fixture.h"

namespace dermap::acquire_test {
namespace {

// The camera dies before each frame in turn.
TEST_F(Sequence, ResumesAfterADeviceFailureAtEveryFrame) {
  const auto hashes = Undisturbed();
  constexpr std::array kOrder{1, 3, 4, 2, 5, 6};
  for (int taken = 0; taken < kSmallPlanFrames; ++taken) {
    const int dies_at = kOrder[static_cast<std::size_t>(taken)];
    fs::remove_all(options_.out);
    options_.resume = false;
    WatchedStation& station = Watch();
    station.before_capture = [&](const CaptureSettings& s) {
      if (s.shot == dies_at) throw DeviceError("unplugged");
    };
    EXPECT_THROW(RunCapture(options_, station), DeviceError);
    if (taken > 0) {
      EXPECT_FALSE(ReadSession(options_.out).complete);
    }
    station.before_capture = nullptr;
    options_.resume = true;
    const CaptureSummary summary = RunCapture(options_, station);
    EXPECT_EQ(summary.kept, taken);
    EXPECT_EQ(summary.taken, kSmallPlanFrames - taken);
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
  WatchedStation& station = Watch();
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

// Frames of one session shall lie in time as they were taken.
TEST_F(Sequence, IsNotResumedByAClockThatStandsBeforeItsBeginning) {
  options_.stop = [asked = 0]() mutable { return ++asked > 2; };
  const std::string began = RunCapture(options_).session.started_utc;
  std::string journal = ReadTextFile(options_.out / "journal.jsonl");
  journal.replace(journal.find(began), 4, "2199");
  folder_.Write("session/journal.jsonl", journal);
  options_.stop = nullptr;
  options_.resume = true;
  EXPECT_THAT(MessageOf<InputError>(options_), HasSubstr("remedy: set the clock"));
  journal.replace(journal.find("2199"), 4, began.substr(0, 4));
  folder_.Write("session/journal.jsonl", journal);
  EXPECT_TRUE(RunCapture(options_).session.complete);
}

// A full disk, as the system tells of it: no file may grow beyond 8 kB, a frame has 10 kB.
TEST_F(Sequence, FullDiskIsAStorageErrorAndCanBeResumed) {
  const auto hashes = Undisturbed();
  WatchedStation& station = Watch();
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
  // Frame 1 was there before; frame 2 comes later.
  const auto files = std::distance(fs::directory_iterator(options_.out / "frames"), fs::directory_iterator{});
  EXPECT_GE(files, 1);
  EXPECT_EQ(RunCapture(options_, station).kept, files);
  ExpectWhole(hashes);
}

}  // namespace
}  // namespace dermap::acquire_test
