// SPDX-License-Identifier: Apache-2.0
// Which frames are told from their gray card to be of another filter, or of no flash. Levels by hand.
#include "acquire/light_memory.h"

#include <gtest/gtest.h>

namespace dermap {
namespace {

FrameRecord Frame(FrameRole role, int slot, int iso = 100) {
  FrameRecord f;
  f.role = role;
  f.slot = slot;
  f.iso = iso;
  return f;
}

FrameCheck Check(const CardLevel& card) {
  FrameCheck check;
  check.decodes = true;
  check.level = 0.5;
  check.card = card;
  return check;
}

class Light : public testing::Test {
 protected:
  Light() {
    memory_.Learn(Frame(FrameRole::kSpectralon, 1), Check({0.02, 0.05, 0.30}));
    memory_.Learn(Frame(FrameRole::kSpectralon, 2), Check({0.02, 0.30, 0.05}));
  }
  LightMemory memory_;
};

TEST_F(Light, OfTheSameFilterIsFineAtAnyIsoAndDriftIsMeasured) {
  const auto judgement = memory_.Judge(Frame(FrameRole::kSkin, 1, 200), Check({0.042, 0.105, 0.63}));
  EXPECT_EQ(judgement.problem, LightProblem::kNone);
  EXPECT_NEAR(judgement.drift, 0.05, 1e-9);
}

TEST_F(Light, OfAnotherFilterNamesIt) {
  const auto judgement = memory_.Judge(Frame(FrameRole::kSkin, 1), Check({0.02, 0.29, 0.05}));
  EXPECT_EQ(judgement.problem, LightProblem::kOtherSlot);
  EXPECT_EQ(judgement.looks_like_slot, 2);
}

// Slot 1 was learnt through another filter: what it gives now looks like none that is known.
TEST_F(Light, OfAnotherColourIsNotTheSameFilterThoughNoOtherFits) {
  const auto judgement = memory_.Judge(Frame(FrameRole::kSkin, 1), Check({0.30, 0.03, 0.02}));
  EXPECT_EQ(judgement.problem, LightProblem::kOtherSlot);
  EXPECT_EQ(judgement.looks_like_slot, 0);
  memory_.Forget(1);
  EXPECT_EQ(memory_.Judge(Frame(FrameRole::kSkin, 1), Check({0.30, 0.03, 0.02})).problem,
            LightProblem::kNone);
}

TEST_F(Light, OfNoFlashIsDark) {
  FrameCheck check = Check({0.0, 0.0, 0.0});
  check.level = 0.01;
  EXPECT_EQ(memory_.Judge(Frame(FrameRole::kSkin, 1), check).problem, LightProblem::kDark);
  EXPECT_EQ(memory_.Judge(Frame(FrameRole::kSkin, 1), Check({0.01, 0.025, 0.15})).problem,
            LightProblem::kDark);
  EXPECT_EQ(memory_.Judge(Frame(FrameRole::kSkin, 1), Check({0.04, 0.1, 0.6})).problem,
            LightProblem::kBright);
}

TEST_F(Light, InABlackFrameIsNoticed) {
  EXPECT_EQ(memory_.Judge(Frame(FrameRole::kBlack, 3), Check({})).problem, LightProblem::kNotBlack);
}

// Saturated: its colour means nothing.
TEST_F(Light, ThatSaturatesTheCardIsNotJudged) {
  EXPECT_EQ(memory_.Judge(Frame(FrameRole::kSkin, 1), Check({0.5, 1.0, 1.0})).problem, LightProblem::kNone);
}

}  // namespace
}  // namespace dermap
