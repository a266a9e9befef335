// SPDX-License-Identifier: Apache-2.0
// A wheel that slipped somewhere between the opaque slot and Spectralon's second filter, told by hand.
#include "acquire/frame_doubts.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace dermap {
namespace {

FrameRecord Spectralon(int number) {
  FrameRecord f;
  f.number = number;
  f.role = FrameRole::kSpectralon;
  return f;
}

TEST(FrameDoubts, DarkOnceIsTheFlashAndDarkTwiceMayBeAnotherSlot) {
  FrameDoubts doubts;
  EXPECT_FALSE(doubts.IsOfAnotherSlot(4, LightProblem::kDark));
  EXPECT_TRUE(doubts.IsOfAnotherSlot(4, LightProblem::kDark));
  EXPECT_TRUE(doubts.IsOfAnotherSlot(5, LightProblem::kOtherSlot));
  EXPECT_FALSE(doubts.IsOfAnotherSlot(6, LightProblem::kBright));
}

TEST(FrameDoubts, WhatWasTakenBeforeHomingHelpedIsWithdrawn) {
  FrameDoubts doubts;
  EXPECT_THAT(doubts.Vouch(Spectralon(2)), testing::IsEmpty());
  EXPECT_FALSE(doubts.IsOfAnotherSlot(4, LightProblem::kDark));
  EXPECT_TRUE(doubts.IsOfAnotherSlot(4, LightProblem::kDark));
  doubts.NoteHoming(4, true, 3);  // 3 was exposed, and is settled only now
  EXPECT_THAT(doubts.Vouch(Spectralon(3)), testing::IsEmpty());
  EXPECT_THAT(doubts.Vouch(Spectralon(4)), testing::ElementsAre(2, 3));
  // From here on the wheel is right: a flash that does not fire twice brings no frame down.
  EXPECT_THAT(doubts.Vouch(Spectralon(5)), testing::IsEmpty());
}

// A wheel that cannot find its slots by itself is right only once the operator has seen to it.
TEST(FrameDoubts, HomingThatFindsNothingProvesNothing) {
  FrameDoubts doubts;
  doubts.Vouch(Spectralon(3));
  for (int i = 0; i < 2; ++i) doubts.IsOfAnotherSlot(4, LightProblem::kDark);
  doubts.NoteHoming(4, false, 0);
  EXPECT_FALSE(doubts.WheelIsRight(4));
  for (int i = 0; i < kFrameTries; ++i) doubts.CountRejection(4);
  doubts.StartOver(4, true);
  EXPECT_TRUE(doubts.WheelIsRight(4));
  EXPECT_FALSE(doubts.IsLastTry(4));
  EXPECT_THAT(doubts.Vouch(Spectralon(4)), testing::ElementsAre(3));
}

// The same light as before: what was in doubt is right.
TEST(FrameDoubts, AFrameThatFitsAfterHomingVouchesForThoseBefore) {
  FrameDoubts doubts;
  doubts.Vouch(Spectralon(3));
  EXPECT_TRUE(doubts.IsOfAnotherSlot(4, LightProblem::kOtherSlot));
  doubts.NoteHoming(4, true, 0);
  EXPECT_THAT(doubts.Vouch(Spectralon(4)), testing::IsEmpty());
}

}  // namespace
}  // namespace dermap
