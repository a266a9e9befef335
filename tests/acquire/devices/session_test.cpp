// SPDX-License-Identifier: Apache-2.0
// Whole sessions on emulated devices that fail. The truth is the same session on the simulated station, which
// nothing disturbs: every frame must show the same light, channel by channel.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "acquire/devices/device_station.h"
#include "acquire/devices/gphoto2_camera.h"
#include "acquire/devices/manual_wheel.h"
#include "acquire/devices/usb_wheel.h"
#include "acquire/emulator/station.h"
#include "acquire/frame_check.h"
#include "acquire/sequence.h"
#include "common/core/error.h"
#include "common/files/atomic_file.h"
#include "common/files/session_journal.h"
#include "tests/acquire/devices/patience.h"
#include "tests/acquire/support.h"

namespace dermap {
namespace {

using namespace std::chrono_literals;
using acquire_test::TemporaryFolder;
using testing::HasSubstr;

constexpr WheelTiming kQuickWheel{.plug_in = 1000ms, .answer = 150ms, .per_slot = 20ms, .poll = 5ms};
constexpr std::size_t kMostQuestions = 12;  // a session that asks more does not come to an end
constexpr double kSameLight = 0.02;         // of the range: a hundred times what the noise of a mean is

class EmulatedSession : public testing::Test {
 protected:
  EmulatedSession() {
    folder_.Write("scene.toml", acquire_test::SmallSceneToml() + "flash_drift = 0\nmotion_shift_mm = 0\n");
    const std::string rig = acquire_test::SmallRigToml("scene.toml");
    simulated_rig_ = folder_.Write("simulated.toml", rig);
    options_.rig = folder_.Write("emulated.toml", WithWheel(rig, "starlight"));
    options_.plan = folder_.Write("plan.toml", acquire_test::SmallPlanToml());
    options_.out = folder_.path() / "session";
    options_.ask = [this](const OperatorRequest& request) { return Obey(request); };
  }

  // With the real camera driver and this one of the wheel.
  static std::string WithWheel(std::string rig, const std::string& driver) {
    const std::string table = "[wheel]\n";
    return rig.replace(rig.find(table), table.size(),
                       "[camera]\ndriver = \"gphoto2\"\n" + table + "driver = \"" + driver + "\"\n");
  }

  bool Obey(const OperatorRequest& request) {
    asked_.push_back(request);
    if (asked_.size() > kMostQuestions) return false;
    if (request.kind == OperatorRequest::Kind::kPlace) devices_->Place(request.role);
    if (request.kind == OperatorRequest::Kind::kTurnWheel) devices_->TurnWheel(request.slot);
    if (request.kind == OperatorRequest::Kind::kFault) devices_->SeeToIt();
    return true;
  }

  void Emulate(std::vector<std::string> faults, const std::string& wheel = "starlight") {
    devices_ =
        std::make_unique<emulator::EmulatedStation>(emulator::StationOptions{.rig = ReadRig(options_.rig),
                                                                             .wheel = wheel,
                                                                             .network_port = {},
                                                                             .real_time = false,
                                                                             .faults = std::move(faults)});
  }

  CaptureSummary Capture(std::unique_ptr<FilterWheel> wheel = MakeStarlightWheel("", kQuickWheel)) {
    DeviceStation station(std::make_unique<Gphoto2Camera>(CameraChoice{}, kQuickCamera), std::move(wheel));
    return RunCapture(options_, station);
  }

  // Means of red, green and blue of every frame.
  static std::vector<CardLevel> LightOf(const Session& session) {
    std::vector<CardLevel> light;
    for (const FrameRecord& f : session.frames) {
      light.push_back(
          CheckFrame({ReadBinaryFile(session.directory / f.file), ".dng"}, {0.0, 0.0, 1.0, 1.0}).card);
    }
    return light;
  }

  void ExpectWhole() {
    const Session session = ReadSession(options_.out);
    EXPECT_TRUE(session.complete);
    VerifyFrames(session);
    CaptureOptions undisturbed;
    undisturbed.rig = simulated_rig_;
    undisturbed.plan = options_.plan;
    undisturbed.out = folder_.path() / "undisturbed";
    const auto truth = LightOf(RunCapture(undisturbed).session), light = LightOf(session);
    ASSERT_EQ(light.size(), truth.size());
    for (std::size_t i = 0; i < light.size(); ++i) {
      for (std::size_t c = 0; c < 3; ++c)
        EXPECT_NEAR(light[i][c], truth[i][c], kSameLight) << "frame " << i + 1;
    }
  }

  // "problem" of the journal's lines of one kind.
  std::vector<std::string> Problems(const std::string& kind) {
    std::vector<std::string> problems;
    for (const auto& event : ReadJournal(options_.out / "journal.jsonl")) {
      if (event.value("event", "") == kind) problems.push_back(event.value("problem", ""));
    }
    return problems;
  }

  TemporaryFolder folder_;
  CaptureOptions options_;
  std::filesystem::path simulated_rig_;
  std::unique_ptr<emulator::EmulatedStation> devices_;
  std::vector<OperatorRequest> asked_;
};

TEST_F(EmulatedSession, AsksTheOperatorForEachTargetOnce) {
  Emulate({});
  const CaptureSummary summary = Capture();
  EXPECT_EQ(summary.taken, acquire_test::kSmallPlanFrames);
  ExpectWhole();
  std::vector<FrameRole> placed;
  for (const OperatorRequest& r : asked_) placed.push_back(r.role);
  EXPECT_THAT(placed, testing::ElementsAre(FrameRole::kBlack, FrameRole::kSpectralon, FrameRole::kSkin));
  EXPECT_EQ(devices_->shots(), acquire_test::kSmallPlanFrames);
  EXPECT_THAT(summary.warnings, testing::IsEmpty());
}

// A Thorlabs wheel obeys nothing while it believes that it moves.
TEST_F(EmulatedSession, GoesOnOnceAJammedThorlabsWheelWasFreed) {
  Emulate({"wheel-stuck@3"}, "thorlabs");
  Capture(MakeThorlabsWheel("", kQuickWheel));
  ExpectWhole();
}

// The wheel falls silent on its move to frame 5, at which the session is ended: it is resumed with a wheel
// that cannot be opened.
TEST_F(EmulatedSession, AsksTheOperatorToSeeToADeviceThatFailsBeforeTheFirstFrame) {
  Emulate({"wheel-silent@5"});
  int asked_to_stop = 0;
  options_.stop = [&] { return ++asked_to_stop > 4; };
  EXPECT_FALSE(Capture().session.complete);
  options_.stop = nullptr;
  options_.resume = true;
  asked_.clear();
  Capture();
  ASSERT_FALSE(asked_.empty());
  EXPECT_EQ(asked_.front().kind, OperatorRequest::Kind::kFault);
  EXPECT_THAT(asked_.front().sentence, HasSubstr("switch it off and on"));
  ExpectWhole();
}

TEST_F(EmulatedSession, SurvivesWhatTheCameraGivesWrongly) {
  Emulate({"busy@1", "stall@3", "truncated@4", "repeated@7", "ram@8", "settings@9"});
  Capture();
  ExpectWhole();
  EXPECT_THAT(Problems("frame_rejected"),
              testing::ElementsAre(HasSubstr("decode"), HasSubstr("once more"), HasSubstr("ISO 800")));
}

TEST_F(EmulatedSession, SurvivesACameraThatGoesAway) {
  Emulate({"unplug@2:0.4", "sleep@4:0.4", "unplug-read@6:0.4", "hang@8:0.6"}, "thorlabs");
  Capture(MakeThorlabsWheel("", kQuickWheel));
  ExpectWhole();
}

// A desktop service is quicker when the camera comes back: for a moment, and for good until the operator ends
// it.
TEST_F(EmulatedSession, SurvivesASecondClient) {
  Emulate({"second-client@2:0.3", "second-client@5:60"});
  Capture();
  ExpectWhole();
  EXPECT_THAT(Problems("paused"), testing::ElementsAre(HasSubstr("end the program that holds it")));
}

TEST_F(EmulatedSession, SurvivesAWheelThatFallsSilent) {
  Emulate({"wheel-silent@3"});
  Capture();
  ExpectWhole();
  EXPECT_THAT(Problems("paused"), testing::SizeIs(1));
}

// Slot 1 saturates at ISO 1600, slot 2 is too dark at 100: through the real drivers, with what the camera
// offers.
TEST_F(EmulatedSession, TakesFiltersAtTheIsoThatSuitsThem) {
  options_.plan =
      folder_.Write("wrong.toml", "[[exposure]]\nslot = 1\niso = 1600\n[[exposure]]\nslot = 2\niso = 100\n");
  Emulate({});
  Capture();
  ExpectWhole();
  EXPECT_EQ(ReadSession(options_.out).exposure_changes.size(), 4u);
}

TEST_F(EmulatedSession, TakesAFrameAgainWhoseFileIsTooLate) {
  Emulate({"late@3:2.2", "missing@5"});
  Capture();
  ExpectWhole();
  EXPECT_THAT(Problems("frame_rejected"), testing::ElementsAre(HasSubstr("lost"), HasSubstr("lost")));
}

// From each move on in turn: before a slot's light is known, dark Spectralon or skin that does not fit tells,
// and what was taken since is withdrawn.
class SlippingWheel : public EmulatedSession, public testing::WithParamInterface<int> {};

TEST_P(SlippingWheel, IsNoticed) {
  Emulate({"wheel-slip@" + std::to_string(GetParam())});
  Capture();
  ExpectWhole();
}

// A Thorlabs wheel cannot be told to find its slots: the operator switches it off and on.
TEST_P(SlippingWheel, IsNoticedWhereOnlyTheOperatorCanHelp) {
  Emulate({"wheel-slip@" + std::to_string(GetParam())}, "thorlabs");
  Capture(MakeThorlabsWheel("", kQuickWheel));
  ExpectWhole();
}

INSTANTIATE_TEST_SUITE_P(FromEachMoveOn, SlippingWheel, testing::Range(2, 8));

// The opaque slot is not where the wheel says it is, from the start.
TEST_F(EmulatedSession, NoticesABlackFrameThatIsLit) {
  Emulate({"wheel-slip@1"});
  Capture();
  ExpectWhole();
}

// Twice in a row as well: pulled again before it was back for good.
TEST_F(EmulatedSession, SurvivesAWheelThatIsUnplugged) {
  Emulate({"wheel-unplug@2:0.3", "wheel-unplug@5:0.3", "wheel-unplug@6:0.3"});
  Capture();
  ExpectWhole();
}

// Faults that last pause the session; once the operator has seen to them it goes on.
TEST_F(EmulatedSession, PausesForAFullCardAndAStuckWheel) {
  Emulate({"full@2:0", "wheel-stuck@3"});
  Capture();
  ExpectWhole();
  EXPECT_THAT(Problems("paused"), testing::ElementsAre(HasSubstr("card"), HasSubstr("wheel")));
}

TEST_F(EmulatedSession, EndsWhereNobodySeesToAFaultAndIsResumed) {
  Emulate({"full@4:0"});
  options_.ask = [this](const OperatorRequest& request) {
    return request.kind != OperatorRequest::Kind::kFault && Obey(request);
  };
  EXPECT_THROW(Capture(), DeviceError);
  EXPECT_FALSE(ReadSession(options_.out).complete);
  devices_->SeeToIt();
  options_.resume = true;
  const CaptureSummary summary = Capture();
  EXPECT_EQ(summary.kept, 3);
  ExpectWhole();
}

TEST_F(EmulatedSession, IsTakenWithAWheelThatTheOperatorTurns) {
  options_.rig = folder_.Write("manual.toml", WithWheel(acquire_test::SmallRigToml("scene.toml"), "manual"));
  Emulate({});
  Capture(std::make_unique<ManualWheel>(ReadRig(options_.rig), options_.ask));
  ExpectWhole();
  EXPECT_THAT(asked_[1].sentence, HasSubstr("slot 3, the opaque one"));
}

TEST_F(EmulatedSession, TakesBlackAndSpectralonFramesOverFromAnEarlierOne) {
  Emulate({});
  Capture();
  asked_.clear();
  options_.reference = options_.out;
  options_.out = folder_.path() / "second";
  const CaptureSummary summary = Capture();
  EXPECT_EQ(summary.from_reference, 4);
  EXPECT_EQ(summary.taken, 2);
  ASSERT_EQ(asked_.size(), 1u);
  EXPECT_EQ(asked_[0].role, FrameRole::kSkin);
  ExpectWhole();
}

}  // namespace
}  // namespace dermap
