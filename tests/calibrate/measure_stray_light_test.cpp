// SPDX-License-Identifier: Apache-2.0
// Stray light and leak measured from targets on the bench: its own numbers are the truth.
#include "calibrate/measure_stray_light.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "calibrate/calibrate.h"
#include "calibrate/failure.h"
#include "calibrate/stray_light.h"
#include "calibrate/target_frames.h"
#include "tests/calibrate/simulated_session.h"

namespace dermap {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr double kShare = 0.015, kLeak = 0.012;
constexpr int kSecond = 1000;  // frame numbers of the second target begin behind this

void TwoBands(PlanConfig& plan) {
  plan.exposures = {plan.exposures[0], plan.exposures[6]};
}

// Targets of two reflectances on one bench, on a stand; `change` befalls the bench of the second one as well.
class Targets {
 public:
  Targets(double first, double second, const std::function<void(BenchConfig&)>& change = {},
          double second_at_mm = 0.0)
      : first_("gray_50.toml", Scenery(first, 0.0, change), TwoBands),
        second_("gray_50.toml", Scenery(second, second_at_mm, change), TwoBands),
        session_(first_.session()) {
    for (FrameRecord frame : second_.session().frames) {
      if (frame.role != FrameRole::kSkin) continue;
      frame.number += kSecond;
      session_.frames.push_back(frame);
    }
    session_.rig.optics.polarization = PolarizationConfig{};
    session_.rig.optics.polarization->sign = -1;
  }
  Session& session() { return session_; }
  FrameReader Reader() const {
    return [this](const FrameRecord& record) {
      return (record.number > kSecond ? second_ : first_).Reader()(record);
    };
  }

 private:
  static std::function<void(Scene&)> Scenery(double reflectance, double at_mm,
                                             const std::function<void(BenchConfig&)>& change) {
    return [=](Scene& scene) {
      scene.pattern = TestPattern{TestPattern::Kind::kFlat, reflectance, reflectance};
      BenchConfig& bench = scene.bench;
      bench.stray_light = kShare;
      bench.polarizer_leak = kLeak;
      bench.polarizer_sign = -1;
      bench.motion_shift_mm = 0.05;
      bench.motion_rotation_deg = 0.1;
      if (change) change(bench);
      bench.window_center_px[0] += at_mm * bench.scale_px_per_mm;
    };
  }

  SimulatedSession first_, second_;
  Session session_;
};

std::string ErrorOf(Targets& targets, const std::optional<Known>& dark = {}) {
  try {
    MeasureStrayLight(targets.session(), targets.Reader(), dark);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

// The tape's reflectance and its texture (15 %) are nobody's business. A frame's offset of 0.1 DN is 5e-5 of
// white; a white target makes a frame brighter by a quarter to a half of white: 1e-4 to 3e-4 of the share.
TEST(MeasureStrayLight, FindsTheBenchsShareAndLeak) {
  Targets targets(0.8, 0.0);
  const auto found = MeasureStrayLight(targets.session(), targets.Reader(), Known{0.0, 1e-4});
  EXPECT_NEAR(found.share.value, kShare, 4.0 * found.share.sigma);
  EXPECT_LT(found.share.sigma, 4e-4);
  ASSERT_TRUE(found.leak);
  EXPECT_NEAR(found.leak->value, kLeak, 4.0 * found.leak->sigma);
  EXPECT_LT(found.leak->sigma, 4e-4);
  EXPECT_GE(found.leak->sigma, 1e-4);
  ASSERT_EQ(found.bands.size(), 2u);
  for (const StrayLightBand& band : found.bands) {
    EXPECT_NEAR(band.share.value, kShare, 5.0 * band.share.sigma) << band.wavelength_nm;
    EXPECT_NEAR(band.tape, 0.03, 0.002) << band.wavelength_nm;  // its texture over the ring
  }
  const std::string toml = StrayLightToml(found);
  EXPECT_THAT(toml, AllOf(HasSubstr("[calibration]\nstray_light = 0.01"),
                          HasSubstr("stray_light_sigma = 0.0"), HasSubstr("[polarization]\nleak = 0.01")));
}

TEST(MeasureStrayLight, FindsNoneWhereThereIsNone) {
  Targets targets(0.8, 0.0, [](BenchConfig& b) { b.stray_light = b.polarizer_leak = 0.0; });
  const auto found = MeasureStrayLight(targets.session(), targets.Reader(), Known{0.0, 1e-4});
  EXPECT_LT(found.share.value, 4.0 * found.share.sigma);
  EXPECT_LT(found.leak->value, 4.0 * found.leak->sigma);
}

// One white target, and the tape's reflectance from elsewhere: 0.001 of it is 0.001 / 0.3 of the share or so.
TEST(MeasureStrayLight, GoesByTheRigsTapeWhereAllTargetsAreAlike) {
  Targets targets(0.8, 0.8);
  targets.session().rig.optics.tape_reflectance = Known{0.03, 0.001};
  const auto found = MeasureStrayLight(targets.session(), targets.Reader(), {});
  EXPECT_NEAR(found.share.value, kShare, 3.0 * found.share.sigma);
  EXPECT_GT(found.share.sigma, 0.001);
  EXPECT_LT(found.share.sigma, 0.004);
  EXPECT_FALSE(found.leak);
  EXPECT_THAT(StrayLightToml(found), ::testing::Not(HasSubstr("leak")));
}

// Each is refused with what is wrong and what to do.
TEST(MeasureStrayLight, RefusesWhatDoesNotTellIt) {
  Targets alike(0.8, 0.8);
  EXPECT_THAT(ErrorOf(alike), AllOf(HasSubstr("equally bright"), HasSubstr("--dark-target")));
  alike.session().rig.optics.tape_reflectance = Known{0.03, 0.01};
  EXPECT_THAT(ErrorOf(alike), HasSubstr("of stray light is told to"));
  alike.session().rig.optics.tape_reflectance = Known{0.06, 0.0005};  // twice what the bench's reflects
  EXPECT_THAT(ErrorOf(alike), HasSubstr("less than none"));
  Targets gray(0.8, 0.3);
  EXPECT_THAT(ErrorOf(gray, Known{0.0, 1e-4}),
              AllOf(HasSubstr("the darkest target"), HasSubstr("black one")));
  Targets moved(0.8, 0.0, {}, 0.5);
  EXPECT_THAT(ErrorOf(moved), HasSubstr("tape moved between the targets"));
  Targets bright(0.8, 0.0, [](BenchConfig& b) { b.white_electrons *= 1.6; });
  EXPECT_THAT(ErrorOf(bright), AllOf(HasSubstr("are saturated"), HasSubstr("lower the ISO")));
  const auto no_leak = [](BenchConfig& b) { b.polarizer_leak = 0.0; };
  Targets no_window(0.03 / 0.8004, 0.03 / 0.8004, no_leak);  // as bright as the bench's tape
  EXPECT_THAT(ErrorOf(no_window), HasSubstr("window"));
  Targets no_white(0.8, 0.0);
  std::erase_if(no_white.session().frames, [](const auto& f) { return f.role == FrameRole::kSpectralon; });
  EXPECT_THAT(ErrorOf(no_white), HasSubstr("no Spectralon frame"));
  Targets lighter(0.8, 0.0, no_leak);
  EXPECT_THAT(ErrorOf(lighter, Known{0.02, 1e-4}), HasSubstr("reflects less than --dark-reflectance"));
}

TEST(JoinSessions, TakesFramesOfOneRigAlone) {
  SimulatedSession white("gray_50.toml", {}, TwoBands);
  Session first = white.session(), second = white.session();
  second.directory = "/other";
  const Session joined = JoinSessions(first, second);
  ASSERT_EQ(joined.frames.size(), 2 * first.frames.size());
  EXPECT_EQ(joined.frames.back().number, 2 * first.frames.back().number);
  EXPECT_EQ(joined.directory / joined.frames.back().file, "/other/" + first.frames.back().file);
  second.rig.name = "another";
  EXPECT_THROW(JoinSessions(first, second), InputError);
}

// The light is gone from the signals, its shot noise is not: by hand, gain x (signal + what was taken off).
TEST(RemoveStrayLight, LeavesItsShotNoise) {
  Mosaic mosaic;
  mosaic.skin = PlaneF(8, 8, 100.0f);
  mosaic.spectralon = PlaneF(8, 8, 1000.0f);
  mosaic.mask = MaskPlane(8, 8);
  FrameMeans means;
  means.skin.fill(500.0);
  means.spectralon.fill(800.0);
  RemoveStrayLight(0.02, means, mosaic);
  EXPECT_FLOAT_EQ(mosaic.skin(3, 3), 90.0f);
  EXPECT_FLOAT_EQ(mosaic.spectralon(3, 3), 984.0f);
  MosaicNoise noise;
  noise.skin = noise.spectralon = {0.1, 2.0, 1};
  const PhotositeNoise of = NoiseOfPhotosites(mosaic, noise);
  EXPECT_NEAR(of.skin_variance(3, 3), 0.1 * 100.0 + 2.0, 1e-4);
  EXPECT_NEAR(of.spectralon_variance(3, 3), std::pow(90.0 / 984.0, 2) * (0.1 * 1000.0 + 2.0), 1e-4);
}

// What the step says of its own uncertainty is what the result does when the share is that much off: the
// gray card, whose ratio changes with it, included.
TEST(StrayLightStep, SaysWhatItsShareLeavesOpen) {
  SimulatedSession simulated(
      "gray_50.toml", [](Scene& scene) { scene.bench.stray_light = 0.02; }, TwoBands);
  const auto calibrate = [&](double share) {
    simulated.session().rig.optics.stray_light = Known{share, 0.002};
    return CalibrateFrames(simulated.session(), simulated.Reader(), {});
  };
  const auto one = calibrate(0.02), other = calibrate(0.022);
  for (std::size_t i = 0; i < one.bands.size(); ++i) {
    const double change = other.bands[i].median_reflectance / one.bands[i].median_reflectance - 1.0;
    for (const StepRecord& step : one.bands[i].steps) {
      if (step.step != Step::kStrayLight) continue;
      EXPECT_NEAR(step.sigma, std::abs(change), 0.1 * std::abs(change));
    }
  }
}

}  // namespace
}  // namespace dermap
