// SPDX-License-Identifier: Apache-2.0
// Frames that are not what the session says. Expected: by definition a CaptureFailure (or InputError) that
// names the frame and what was found, with a picture of it.
#include "calibrate/failure.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calibrate/calibrate.h"
#include "tests/calibrate/simulated_session.h"

namespace dermap {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

struct Failure {
  std::string message = "no failure";
  bool picture = false;
};

Failure FailureOf(const Session& session, const FrameReader& read) {
  try {
    CalibrateFrames(session, read, {});
  } catch (const CaptureFailure& failure) {
    return {failure.what(), failure.picture().width() > 100 && failure.picture().height() > 100};
  } catch (const InputError& error) {
    return {error.what(), false};
  }
  return {};
}

void TwoBands(PlanConfig& plan) {
  plan.exposures = {plan.exposures[0], plan.exposures[6]};
}

// Reads `other` where `frame` is asked for.
FrameReader Swapped(const SimulatedSession& simulated, const FrameRecord& frame, const FrameRecord& other) {
  return [honest = simulated.Reader(), frame, other](const FrameRecord& record) {
    if (record.number == frame.number) return honest(other);
    if (record.number == other.number) return honest(frame);
    return honest(record);
  };
}

TEST(Failures, NameASkinFrameAndASpectralonFrameThatWereSwapped) {
  SimulatedSession simulated("gray_50.toml", {}, TwoBands);
  const auto skin = simulated.Frames(FrameRole::kSkin, 450.0).at(0);
  const auto white = simulated.Frames(FrameRole::kSpectralon, 450.0).at(0);
  const Failure failure = FailureOf(simulated.session(), Swapped(simulated, skin, white));
  EXPECT_THAT(failure.message, AllOf(HasSubstr(white.file), HasSubstr("as a skin frame does")));
  EXPECT_TRUE(failure.picture);
}

TEST(Failures, NameAFrameThroughAnotherFilter) {
  SimulatedSession simulated("gray_50.toml", {}, TwoBands);
  const auto skin = simulated.Frames(FrameRole::kSkin, 450.0).at(0);
  const auto other = simulated.Frames(FrameRole::kSkin, 610.0).at(0);
  const Failure failure = FailureOf(simulated.session(), Swapped(simulated, skin, other));
  EXPECT_THAT(failure.message, AllOf(HasSubstr("colours differ"), HasSubstr("filter was out of order")));
  EXPECT_TRUE(failure.picture);
}

// Both frames of two bands swapped: nothing within a band gives it away, but the rig's curves do.
TEST(Failures, NameAFilterThatIsOutOfOrderForBothOfItsFrames) {
  SimulatedSession simulated("gray_50.toml", {}, TwoBands);
  for (FrameRecord& frame : simulated.session().frames) {
    if (frame.role != FrameRole::kBlack) frame.wavelength_nm = frame.wavelength_nm == 450.0 ? 610.0 : 450.0;
  }
  EXPECT_THAT(FailureOf(simulated.session(), simulated.Reader()).message,
              AllOf(HasSubstr("colours are not those of the filter at"), HasSubstr("compare the wheel")));
}

TEST(Failures, NameALitBlackFrame) {
  SimulatedSession simulated("gray_50.toml", {}, TwoBands);
  const auto black = simulated.Frames(FrameRole::kBlack).at(0);
  const auto white = simulated.Frames(FrameRole::kSpectralon, 450.0).at(0);
  // Some cameras' files state no black level: a black frame is none the worse for it, a lit one is still
  // told.
  for (const bool stated : {true, false}) {
    const auto level = [&](const FrameReader& read) {
      return [=](const FrameRecord& record) {
        BayerFrame frame = read(record);
        if (!stated) frame.black_level = 0.0;
        return frame;
      };
    };
    const Failure failure = FailureOf(simulated.session(), level(Swapped(simulated, black, white)));
    EXPECT_THAT(failure.message, AllOf(HasSubstr(black.file), HasSubstr("black frame is lit"))) << stated;
    EXPECT_TRUE(failure.picture) << stated;
    EXPECT_EQ(FailureOf(simulated.session(), level(simulated.Reader())).message, "no failure") << stated;
  }
}

TEST(Failures, NameASpectralonFrameThatIsSaturated) {
  SimulatedSession simulated("gray_50.toml", {}, TwoBands);
  const auto white = simulated.Frames(FrameRole::kSpectralon, 450.0).at(0);
  const FrameReader read = [&, honest = simulated.Reader()](const FrameRecord& record) {
    BayerFrame frame = honest(record);
    if (record.number == white.number) {
      for (auto& v : frame.values.values())
        v = static_cast<std::uint16_t>(std::min(4095, (v - 126) * 40 + 126));
    }
    return frame;
  };
  const Failure failure = FailureOf(simulated.session(), read);
  EXPECT_THAT(failure.message, AllOf(HasSubstr(white.file), HasSubstr("Spectralon is saturated")));
  EXPECT_TRUE(failure.picture);
}

// The frame's right part slides down by 60 photosites: the card lies half beside its region.
TEST(Failures, NameAGrayCardThatMoved) {
  SimulatedSession simulated("gray_50.toml", {}, TwoBands);
  const auto skin = simulated.Frames(FrameRole::kSkin, 450.0).at(0);
  const FrameReader read = [&, honest = simulated.Reader()](const FrameRecord& record) {
    BayerFrame frame = honest(record);
    if (record.number != skin.number) return frame;
    const auto before = frame.values;
    for (int y = 60; y < before.height(); ++y) {
      for (int x = 370; x < before.width(); ++x) frame.values(x, y) = before(x, y - 60);
    }
    return frame;
  };
  const Failure failure = FailureOf(simulated.session(), read);
  EXPECT_THAT(failure.message, AllOf(HasSubstr(skin.file), HasSubstr("gray card moved")));
  EXPECT_TRUE(failure.picture);
}

// No light at all: the message offers the cap beside the flash.
TEST(Failures, NameADarkFrame) {
  SimulatedSession simulated(
      "gray_50.toml", [](Scene& scene) { scene.bench.misfired_shots = {4}; }, TwoBands);
  const Failure failure = FailureOf(simulated.session(), simulated.Reader());
  EXPECT_THAT(failure.message, AllOf(HasSubstr("flash did not fire"), HasSubstr("lens cap")));
  EXPECT_TRUE(failure.picture);
}

}  // namespace
}  // namespace dermap
