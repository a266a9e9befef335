// SPDX-License-Identifier: Apache-2.0
// The steps from sensor values to reflectance, each on a bench that has its effect, and by hand.
#include "calibrate/corrections.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "calibrate/calibrate.h"
#include "calibrate/polarization.h"
#include "tests/calibrate/simulated_session.h"

namespace dermap {
namespace {

void OneBand(PlanConfig& plan) {
  plan.exposures = {plan.exposures[3]};
}

// [D08 6.4]: (1 - 0.0527) / (1 - 0.1996) = 1.18353 with the weaker position, (1 + 0.0527) / (1 + 0.1996) =
// 0.87754 with the stronger one.
TEST(PolarizationFactor, IsThePapersQuotient) {
  PolarizationConfig config;
  config.sign = -1;
  EXPECT_NEAR(PolarizationFactor(config, 550.0).value, 1.18353, 1e-4);
  config.sign = 1;
  EXPECT_NEAR(PolarizationFactor(config, 550.0).value, 0.87754, 1e-4);
  config.sign = 0;
  EXPECT_EQ(PolarizationFactor(config, 550.0).value, 1.0);
  // Linear between the wavelengths of the rig, constant beyond: skin 0.15 at 550 nm.
  config = {-1, {500.0, 600.0}, {0.05, 0.05}, {0.20, 0.10}, 0.0, 0.0, {}};
  EXPECT_NEAR(PolarizationFactor(config, 550.0).value, 0.95 / 0.85, 1e-12);
  EXPECT_NEAR(PolarizationFactor(config, 700.0).value, 0.95 / 0.90, 1e-12);
  EXPECT_EQ(PolarizationFactor(config, 550.0).sigma, 0.0);
}

// By hand: 1 / (1 - 0.1996) = 1.24938 beside skin's own light, 1 / (1 - 0.0527) = 1.05563 where that is left
// as it is.
TEST(LeakInReflectance, IsNoLightThatSkinHasScattered) {
  PolarizationConfig config;
  config.sign = -1;
  EXPECT_NEAR(LeakInReflectance(config, 550.0, true), 1.24938, 1e-5);
  EXPECT_NEAR(LeakInReflectance(config, 550.0, false), 1.05563, 1e-5);
  config.sign = 0;
  EXPECT_EQ(LeakInReflectance(config, 550.0, true), 1.0);
}

// A film of air's or of skin's own index is no film.
TEST(GelFactor, IsOneForAFilmThatIsNone) {
  for (const double n : {1.0, 1.4}) {
    EXPECT_NEAR(GelFactor({n, 0.0}, 1.4, {0.0, 30.0}, 0.4).value, 1.0, 2e-4) << n;
  }
}

// By hand, along the normal: bare 1 - (0.4 / 2.4)^2 = 0.97222; under gel (1 - (0.34 / 2.34)^2) (1 - (0.06 /
// 2.74)^2) / (1 - product) = 0.97843; twice that quotient for black skin, where nothing goes back and forth.
TEST(GelFactor, IsTheQuotientOfTheFacesForBlackSkin) {
  const double quotient = 0.97222 / 0.97843;
  EXPECT_NEAR(GelFactor({1.34, 0.0}, 1.4, {0.0, 0.0}, 0.0).value, quotient * quotient, 1e-4);
  EXPECT_GT(GelFactor({1.34, 0.02}, 1.4, {0.0, 30.0}, 0.4).sigma, 5e-4);
}

// By hand, Fresnel's formulas at 30 degrees in air: bare, cos 0.866025 goes on at 0.934050, s (0.441644
// / 2.173695)^2 = 0.041281, p (0.278386 / 2.146485)^2 = 0.016820, so 1 - 0.029051 = 0.970949 gets through.
// Into gel, at 0.927777, 0.031980 and 0.012417, mean 0.022199; from there into skin 0.000638 and 0.000343,
// mean 0.000491; both faces (1 - 0.022199) (1 - 0.000491) / (1 - 0.022199 * 0.000491) = 0.977332. At 45
// degrees 0.963421 and 0.970706, along the normal 0.972222 and 0.978429. Light and camera may be exchanged.
TEST(GelFactor, TakesTheFacesAtTheRigsOwnAngles) {
  const double at_0 = 0.972222 / 0.978429, at_30 = 0.970949 / 0.977332, at_45 = 0.963421 / 0.970706;
  const auto factor = [](double light_deg, double view_deg) {
    return GelFactor({1.34, 0.0}, 1.4, {light_deg, view_deg}, 0.0).value;
  };
  EXPECT_NEAR(factor(0.0, 30.0), at_0 * at_30, 3e-6);
  EXPECT_NEAR(factor(30.0, 0.0), at_0 * at_30, 3e-6);
  EXPECT_NEAR(factor(30.0, 30.0), at_30 * at_30, 3e-6);
  EXPECT_NEAR(factor(45.0, 0.0), at_0 * at_45, 3e-6);
}

// The same numbers: bare skin seen at 45/0 in place of 0/30 is darker by 0.963421 / 0.970949.
TEST(AnglesFactor, IsTheQuotientOfTheBareFaces) {
  EXPECT_EQ(AnglesFactor({0.0, 30.0}, 1.4), 1.0);
  EXPECT_NEAR(AnglesFactor({30.0, 0.0}, 1.4), 1.0, 1e-12);
  EXPECT_NEAR(AnglesFactor({45.0, 0.0}, 1.4), 0.963421 / 0.970949, 2e-6);
}

// A rig's own angles reach the step: the same frames, told that light falls at 45 degrees. Expected: the
// quotient of the two factors by hand, above; what goes back and forth changes it by less than 2e-4.
TEST(GelFactor, FollowsTheRigsLight) {
  SimulatedSession simulated("gray_50.toml", {}, OneBand);
  RigConfig& rig = simulated.session().rig;
  rig.optics.gel = Known{1.34, 0.0};
  const auto upright = CalibrateFrames(simulated.session(), simulated.Reader(), {});
  rig.light_angle_deg = 45.0;
  rig.view_angle_deg = 30.0;
  const auto slanting = CalibrateFrames(simulated.session(), simulated.Reader(), {});
  const double quotient = (0.963421 / 0.970706) / (0.972222 / 0.978429);
  EXPECT_NEAR(slanting.bands[0].median_reflectance / upright.bands[0].median_reflectance, quotient, 2e-4);
  // 0.963421 / 0.972222 is 0.9 % below 1.
  EXPECT_THAT(slanting.notes, ::testing::Contains(::testing::HasSubstr("0.9")));
  EXPECT_THAT(upright.notes, ::testing::Not(::testing::Contains(::testing::HasSubstr("camera at"))));
}

TEST(Steps, AreFoundByName) {
  for (std::size_t i = 0; i < kStepNames.size(); ++i)
    EXPECT_EQ(StepFromName(kStepNames[i]), static_cast<Step>(i));
  EXPECT_FALSE(StepFromName("blakc"));
}

struct Effect {
  const char* name;
  Step step;
  double least_without;  // error of 0.5 when the step is left out
  void (*on_bench)(BenchConfig&);
  void (*on_rig)(RigOptics&);
};

// A patch of 0.5 on a bench with one strong effect: right with its step, wrong without it. The least error
// without it follows from the effect: 20 % against 5 % of polarization, 3 % of the frame's mean light, and so
// on.
TEST(Steps, EachMendsItsOwnEffect) {
  const Effect effects[] = {
      {"polarization", Step::kPolarization, 0.05, [](BenchConfig& b) { b.polarizer_sign = -1; },
       [](RigOptics& o) {
         o.polarization = PolarizationConfig{};
         o.polarization->sign = -1;
       }},
      {"stray light", Step::kStrayLight, 0.003, [](BenchConfig& b) { b.stray_light = 0.03; },
       [](RigOptics& o) {
         o.tape_reflectance = Known{0.03, 0.0003};
       }},
      {"stray light that the rig states", Step::kStrayLight, 0.003,
       [](BenchConfig& b) { b.stray_light = 0.03; },
       [](RigOptics& o) {
         o.stray_light = Known{0.03, 0.001};
       }},
      {"leak", Step::kLeak, 0.015, [](BenchConfig& b) { b.polarizer_leak = 0.02; },
       [](RigOptics& o) {
         o.polarization = PolarizationConfig{};
         o.polarization->leak = {0.02, 0.002};
       }},
      // The leak is no light that skin has scattered: 0.02 of white is 0.02 / (1 - 0.1996) of skin.
      {"leak through the weaker position", Step::kLeak, 0.02,
       [](BenchConfig& b) { b.polarizer_leak = 0.02, b.polarizer_sign = -1; },
       [](RigOptics& o) {
         o.polarization = PolarizationConfig{};
         o.polarization->sign = -1;
         o.polarization->leak = {0.02, 0.002};
       }},
      {"nonlinearity", Step::kLinearity, 0.003, [](BenchConfig& b) { b.nonlinearity = 0.05; },
       [](RigOptics& o) {
         o.nonlinearity = Known{0.05, 0.001};
       }},
      {"flash drift", Step::kFlashDrift, 0.003, [](BenchConfig& b) { b.flash_drift = 0.2; },
       [](RigOptics&) {}},
  };
  for (const Effect& effect : effects) {
    SimulatedSession simulated(
        "gray_50.toml", [&](Scene& scene) { effect.on_bench(scene.bench); }, OneBand);
    effect.on_rig(simulated.session().rig.optics);
    CalibrationOptions options;
    const auto with = CalibrateFrames(simulated.session(), simulated.Reader(), options);
    options.skip = {effect.step};
    const auto without = CalibrateFrames(simulated.session(), simulated.Reader(), options);
    EXPECT_NEAR(with.bands[0].median_reflectance, 0.5, 0.0015) << effect.name;
    EXPECT_GT(std::abs(without.bands[0].median_reflectance - 0.5), effect.least_without) << effect.name;
    // The record tells what was done, and what is left open where it was not.
    for (const StepRecord& record : with.bands[0].steps) {
      if (record.step != effect.step) continue;
      EXPECT_TRUE(record.applied) << effect.name;
      const double change = with.bands[0].median_reflectance / without.bands[0].median_reflectance - 1.0;
      EXPECT_NEAR(record.effect, change, 0.1 * std::abs(change) + 5e-4) << effect.name;
    }
    EXPECT_GT(without.bands[0].systematic_sigma, with.bands[0].systematic_sigma) << effect.name;
  }
}

// The bench's own 3 % of stray light, on sensors of other patterns; the least error without the step as
// above.
TEST(Steps, StrayLightIsMendedUnderEveryFilterPattern) {
  for (const auto filters : {BenchConfig::Filters::kXTrans, BenchConfig::Filters::kNone}) {
    const auto change = [&](Scene& scene) { scene.bench.filters = filters, scene.bench.stray_light = 0.03; };
    SimulatedSession simulated("gray_50.toml", change, OneBand);
    simulated.session().rig.optics.tape_reflectance = Known{0.03, 0.0003};
    CalibrationOptions options;
    const auto with = CalibrateFrames(simulated.session(), simulated.Reader(), options);
    options.skip = {Step::kStrayLight};
    const auto without = CalibrateFrames(simulated.session(), simulated.Reader(), options);
    EXPECT_NEAR(with.bands[0].median_reflectance, 0.5, 0.0015) << int(filters);
    EXPECT_GT(std::abs(without.bands[0].median_reflectance - 0.5), 0.003) << int(filters);
  }
}

// What is known beforehand and what the tape says, by inverse variance. By hand: a tape known to 0.005 of a
// frame whose mean is a quarter of Spectralon's tells the share to 0.005 / (0.26 - 0.03), 0.022; what was
// stated to 0.001 moves by 0.01 (0.001 / 0.022)^2, 2e-5; what was stated to 0.5 counts for nothing.
TEST(Steps, StrayLightIsBelievedAsFarAsItIsKnown) {
  const auto change = [](Scene& scene) { scene.bench.stray_light = 0.03; };
  SimulatedSession simulated("gray_50.toml", change, OneBand);
  RigOptics& optics = simulated.session().rig.optics;
  const auto note = [&] {
    const CalibrationResult result = CalibrateFrames(simulated.session(), simulated.Reader(), {});
    for (const StepRecord& step : result.bands[0].steps) {
      if (step.step == Step::kStrayLight) return std::stod(step.note);
    }
    return 0.0;
  };
  optics.tape_reflectance = Known{0.03, 0.005};
  optics.stray_light = Known{0.02, 0.001};
  EXPECT_NEAR(note(), 2.0, 0.05);  // %
  optics.stray_light = Known{0.02, 0.5};
  EXPECT_NEAR(note(), 3.0, 0.3);  // the tape's own texture in it
  optics.tape_reflectance.reset();
  EXPECT_NEAR(note(), 2.0, 1e-6);
}

// Frames of two benches that differ in the polarizer's position alone; the bench's own amplitudes.
TEST(Polarization, IsMeasuredFromFramesInBothPositions) {
  const auto plan = [](PlanConfig& p) {
    OneBand(p);
    p.spectralon_frames = p.skin_frames = 4;
  };
  SimulatedSession weak(
      "gray_50.toml", [](Scene& s) { s.bench.polarizer_sign = -1; }, plan);
  SimulatedSession strong(
      "gray_50.toml", [](Scene& s) { s.bench.polarizer_sign = 1, s.seed = 77; }, plan);
  Session both = weak.session();
  for (FrameRecord& frame : both.frames) frame.polarizer = "p";
  for (FrameRecord frame : strong.session().frames) {
    if (frame.role == FrameRole::kBlack) continue;
    frame.number += 1000;
    frame.polarizer = "s";
    both.frames.push_back(frame);
  }
  const auto found = MeasurePolarization(both, [&](const FrameRecord& record) {
    FrameRecord own = record;
    if (record.number < 1000) return weak.Reader()(own);
    own.number -= 1000;
    return strong.Reader()(own);
  });
  ASSERT_EQ(found.bands.size(), 1u);
  const double sigma = found.bands[0].skin.sigma;
  EXPECT_LT(sigma, 0.02);  // sixteen flashes that scatter by 2 %
  EXPECT_NEAR(found.bands[0].skin.value, 0.1996, 4.0 * sigma);
  EXPECT_NEAR(found.bands[0].spectralon.value, 0.0527, 4.0 * found.bands[0].spectralon.sigma);
  const std::string toml = PolarizationToml(found);
  EXPECT_THAT(toml, ::testing::HasSubstr("[polarization]"));
  EXPECT_THAT(toml, ::testing::HasSubstr("polarizer at p"));
}

}  // namespace
}  // namespace dermap
