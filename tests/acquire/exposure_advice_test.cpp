// SPDX-License-Identifier: Apache-2.0
// Levels are in proportion to ISO; numbers by hand.
#include "acquire/exposure_advice.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace dermap {
namespace {

constexpr double kCard = 0.30;

FrameRecord Frame(FrameRole role, int iso) {
  FrameRecord f;
  f.role = role;
  f.iso = iso;
  return f;
}

FrameCheck Check(double level, double saturated_share, double card) {
  FrameCheck check;
  check.level = level;
  check.saturated_share = saturated_share;
  check.card = {0.1 * card, 0.3 * card, card};
  return check;
}

TEST(ExposureAdvice, LeavesAGoodFrameAlone) {
  const auto advice = AdviseExposure(Frame(FrameRole::kSpectralon, 400), Check(0.80, 0.0005, 0.24), kCard);
  EXPECT_EQ(advice.problem, ExposureProblem::kNone);
  EXPECT_TRUE(advice.isos.empty());
}

// The card at 0.6 stands for Spectralon at 0.6 / 0.30 = 2 times white: 0.75 needs 800 * 0.375 = 300, so 250.
TEST(ExposureAdvice, SeesByTheCardHowFarBeyondWhiteSpectralonIs) {
  const auto advice = AdviseExposure(Frame(FrameRole::kSpectralon, 800), Check(1.0, 0.3, 0.6), kCard);
  EXPECT_EQ(advice.problem, ExposureProblem::kSaturated);
  EXPECT_THAT(advice.isos, testing::ElementsAre(250, 200, 160, 125, 100));
  EXPECT_EQ(advice.why, "30.0 % of the photosites are saturated");
}

TEST(ExposureAdvice, GoesDownAStopWhereNothingTellsHowFar) {
  EXPECT_EQ(AdviseExposure(Frame(FrameRole::kSpectralon, 800), Check(1.0, 0.5, 1.0), kCard).isos.front(),
            400);
  EXPECT_EQ(AdviseExposure(Frame(FrameRole::kSkin, 200), Check(1.0, 0.01, 0.5), kCard).isos.front(), 100);
}

// 100 * 0.75 / 0.15 = 500
TEST(ExposureAdvice, RaisesADarkFilterToTheSameLevel) {
  const auto advice = AdviseExposure(Frame(FrameRole::kSpectralon, 100), Check(0.15, 0.0, 0.045), kCard);
  EXPECT_EQ(advice.problem, ExposureProblem::kUnderexposed);
  EXPECT_EQ(advice.isos.front(), 500);
  EXPECT_EQ(advice.isos.back(), 125);
}

// Dark skin beside a card in range is as the plan meant it: its level is 1 / 99 of Spectralon's for every
// percent.
TEST(ExposureAdvice, DoesNotTakeDarkSkinForAnUnderexposedFrame) {
  EXPECT_EQ(AdviseExposure(Frame(FrameRole::kSkin, 100), Check(0.15, 0.0, 0.2), kCard).problem,
            ExposureProblem::kNone);
}

// Below ISO 100 the well fills before the numbers reach white.
TEST(ExposureAdvice, HasNothingToProposeBeyondTheEnds) {
  EXPECT_TRUE(AdviseExposure(Frame(FrameRole::kSpectralon, 100), Check(1.0, 0.3, 0.6), kCard).isos.empty());
  EXPECT_TRUE(AdviseExposure(Frame(FrameRole::kSpectralon, 6400), Check(0.1, 0.0, 0.03), kCard).isos.empty());
}

TEST(ExposureAdvice, NeverJudgesBlackFrames) {
  EXPECT_EQ(AdviseExposure(Frame(FrameRole::kBlack, 100), Check(0.0, 0.0, 0.0), kCard).problem,
            ExposureProblem::kNone);
}

}  // namespace
}  // namespace dermap
