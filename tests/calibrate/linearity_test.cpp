// SPDX-License-Identifier: Apache-2.0
// How the sensor answers to light, found in frames of a bench whose sensor is bent by a known amount, and in
// frames whose values stop where they should not.
#include "calibrate/linearity.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <iostream>
#include <random>

#include "calibrate/calibrate.h"
#include "calibrate/saturation.h"
#include "tests/calibrate/simulated_session.h"

namespace dermap {
namespace {

using ::testing::HasSubstr;

void FourBands(PlanConfig& plan) {
  plan.exposures = {plan.exposures[0], plan.exposures[3], plan.exposures[5], plan.exposures[7]};
}

SimulatedSession Bent(double nonlinearity, BenchConfig::Filters filters = BenchConfig::Filters::kRggb,
                      void (*plan)(PlanConfig&) = FourBands) {
  SimulatedSession simulated(
      "gray_50.toml",
      [&](Scene& scene) {
        scene.bench.nonlinearity = nonlinearity;
        scene.bench.filters = filters;
      },
      plan);
  simulated.session().rig.optics.nonlinearity.reset();
  return simulated;
}

// The bench's own number, within four of the standard deviations that are claimed; and the patch of 0.5 comes
// out as on a straight sensor, while without the step it does not.
TEST(Linearity, IsFoundInTheSpectralonFrames) {
  for (const double truth : {0.0, 0.01, -0.05}) {
    SimulatedSession simulated = Bent(truth);
    CalibrationOptions options;
    const auto with = CalibrateFrames(simulated.session(), simulated.Reader(), options);
    ASSERT_TRUE(with.linearity.measured.has_value());
    const Known found = with.linearity.measured->nonlinearity;
    std::cout << truth << ": found " << found.value << " +- " << found.sigma << ", chi2 "
              << with.linearity.measured->chi2 << "\n";
    EXPECT_LT(found.sigma, 0.002);
    EXPECT_NEAR(found.value, truth, 4.0 * found.sigma);
    options.skip = {Step::kLinearity};
    const auto without = CalibrateFrames(simulated.session(), simulated.Reader(), options);
    for (std::size_t b = 0; b < with.bands.size(); ++b) {
      EXPECT_NEAR(with.bands[b].median_reflectance, 0.5, 0.001) << truth;
      // Half of the signal is missing at 0.5, a third of the range at least: k / 2 / 3 of 0.5.
      EXPECT_GE(std::abs(without.bands[b].median_reflectance - 0.5), std::abs(truth) / 12 - 0.0005) << truth;
    }
  }
}

// Without filters all photosites stand at one level: nothing is told, and nothing made up.
TEST(Linearity, IsNotToldByASensorWithoutFilters) {
  SimulatedSession simulated =
      Bent(0.05, BenchConfig::Filters::kNone, [](PlanConfig& plan) { plan.exposures = {plan.exposures[3]}; });
  const auto result = CalibrateFrames(simulated.session(), simulated.Reader(), {});
  EXPECT_FALSE(result.linearity.used.has_value());
  EXPECT_THAT(result.linearity.note, HasSubstr("do not tell"));
}

// A rig file of another camera: its number is used as it is asked for, and the frames object.
TEST(Linearity, ObjectsToARigThatSaysOtherwise) {
  SimulatedSession simulated = Bent(0.0);
  simulated.session().rig.optics.nonlinearity = Known{0.03, 0.001};
  const auto result = CalibrateFrames(simulated.session(), simulated.Reader(), {});
  EXPECT_EQ(result.linearity.used->value, 0.03);
  EXPECT_THAT(result.notes, ::testing::Contains(HasSubstr("the rig states a nonlinearity of 3 +- 0.1 %")));
}

BayerFrame NoisyFrame(double bright, double sigma, int stop) {
  BayerFrame frame;
  frame.values = Plane<std::uint16_t>(400, 300);
  frame.white_level = 4095;
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  for (int y = 0; y < 300; ++y) {
    for (int x = 0; x < 400; ++x) {
      const double level = LatticeOf(x, y) == 0 ? 0.4 * bright : bright;
      frame.values(x, y) = static_cast<std::uint16_t>(
          std::clamp(std::lround(level * (1.0 + 0.0005 * x) + sigma * normal(random)), 0L, long(stop)));
    }
  }
  return frame;
}

// By construction: the value at which the frame was cut, within the width of a pile; else what is stated.
TEST(SaturationLevel, IsWhereValuesPileUp) {
  EXPECT_NEAR(SaturationLevel(NoisyFrame(3000, 15, 3200), 4095), 3200, 12);
  EXPECT_NEAR(SaturationLevel(NoisyFrame(5000, 15, 3200), 4095), 3200, 12);
  EXPECT_EQ(SaturationLevel(NoisyFrame(3000, 15, 4095), 4095), 4095);
  EXPECT_EQ(SaturationLevel(NoisyFrame(5000, 15, 4095), 4095), 4095);
  EXPECT_EQ(SaturationLevel(NoisyFrame(3000, 0, 4095), 4095), 4095);  // even and without noise is not clipped
}

// A converter that stops at 2600 of 4095 DN, of which the file knows nothing: the colour that stops is left
// out, the others tell the patch of 0.5.
TEST(SaturationLevel, KeepsAColourThatStopsOutOfTheStack) {
  SimulatedSession simulated("gray_50.toml", {}, [](PlanConfig& plan) { plan.exposures.resize(1); });
  const FrameReader whole = simulated.Reader();
  const FrameReader read = [&](const FrameRecord& record) {
    BayerFrame frame = whole(record);
    for (auto& v : frame.values.values()) v = std::min<std::uint16_t>(v, 2600);
    return frame;
  };
  const auto result = CalibrateFrames(simulated.session(), read, {});
  EXPECT_NEAR(result.bands[0].median_reflectance, 0.5, 0.003);
  EXPECT_GT(result.bands[0].saturated_share, 0.05);
  EXPECT_THAT(result.bands[0].notes, ::testing::Contains(HasSubstr("below the white level of 4095")));
}

}  // namespace
}  // namespace dermap
