// SPDX-License-Identifier: Apache-2.0
// A session whose plan was wrong about the light: exposures are changed while the target is in place.

#include <map>
#include <set>

#include "acquire/simulated/dng_writer.h"
#include "tests/acquire/sequence_fixture.h"

namespace dermap::acquire_test {
namespace {

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
  // The plan's black frames at ISO 100 and 1600, of which one comes first, and one at ISO 200 before the
  // skin.
  EXPECT_EQ(summary.total, 7);
  using enum FrameRole;
  ASSERT_EQ(order_.size(), 7u);
  EXPECT_EQ(order_.front(), kBlack);
  EXPECT_THAT(std::vector(order_.begin() + 1, order_.begin() + 4),
              testing::UnorderedElementsAre(kSpectralon, kSpectralon, kBlack));
  EXPECT_THAT(std::vector(order_.begin() + 4, order_.end()), testing::ElementsAre(kBlack, kSkin, kSkin));
  ExpectBalanced(session);
  VerifyFrames(session);
  EXPECT_EQ(session.plan.exposures[0].iso, 1600) << "the plan stays what was asked for";
}

// A weak flash is not the filter's fault: the next frame is fine, and nothing is changed.
TEST_F(AdaptedSequence, DoesNotRaiseTheIsoForOneWeakFlash) {
  options_.plan = folder_.path() / "plan.toml";
  WatchedStation& station = Watch();
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
    WatchedStation& station = Watch();
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
  WatchedStation& station = Watch();
  station.after_capture = [&](const CaptureSettings& s, RawFrame& frame) {
    if (s.shot != 6 || s.iso != 250) return;
    auto bayer = simulated_->bench().Expose({FrameRole::kSkin, 2, 10.0, 250, 6});
    for (int i = 0; i < 96; ++i) bayer(i, 40) = 4095;
    frame.bytes = EncodeDng(bayer, MetadataOfShot(simulated_->bench(), {FrameRole::kSkin, 2, 10.0, 250, 6}));
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
}  // namespace dermap::acquire_test
