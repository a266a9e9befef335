// SPDX-License-Identifier: Apache-2.0
// Sums by hand.
#include "acquire/timeline.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace dermap {
namespace {

// Frames every 4 s, as a flash allows: exposing 0.2 s, fetching 0.8 s, the wheel turns 0.6 s beside that.
FrameTiming Frame(int number, double pressed_s, double wheel_start_s) {
  FrameTiming f;
  f.number = number;
  f.good = true;
  f.wheel = {wheel_start_s, wheel_start_s + 0.6};
  f.expose = {pressed_s, pressed_s + 0.2};
  f.flash = {pressed_s, pressed_s + 4.0};
  f.fetch = {pressed_s + 0.2, pressed_s + 1.0};
  f.check = {pressed_s + 1.0, pressed_s + 1.1};
  f.write = {pressed_s + 1.1, pressed_s + 1.2};
  return f;
}

// 0.6 s to the first press; two times 4 s of recycling, and 1.2 s of the last frame: 9.8 s against the
// flash's 8 s.
TEST(Timeline, HoldsTheSessionAgainstItsSlowestDevice) {
  const SessionTimeline timeline{{Frame(1, 0.6, 0.0), Frame(2, 4.6, 0.9), Frame(3, 8.6, 4.9)}, {}};
  const ChainTimes c = AddUp(timeline);
  EXPECT_NEAR(c.camera_s, 3.0, 1e-9);
  EXPECT_NEAR(c.wheel_s, 1.8, 1e-9);
  EXPECT_NEAR(c.flash_s, 8.0, 1e-9);
  EXPECT_NEAR(c.slowest_s(), 8.0, 1e-9);
  EXPECT_NEAR(c.taken_s, 9.8, 1e-9);
  EXPECT_NEAR(c.overhead(), 0.225, 1e-9);
}

// What must follow each other: three exposures of 0.2 s, 3.8 s of recycling after two of them, 0.8 s of
// fetching.
TEST(Timeline, KnowsWhatMustFollowEachOther) {
  const SessionTimeline timeline{{Frame(1, 0.6, 0.0), Frame(2, 4.6, 0.9), Frame(3, 8.6, 4.9)}, {}};
  EXPECT_NEAR(AddUp(timeline).turns_s, 3 * 0.2 + 2 * 3.8 + 0.8, 1e-9);
  SessionTimeline no_flash = timeline;
  for (FrameTiming& f : no_flash.frames) f.flash = {};
  EXPECT_NEAR(AddUp(no_flash).turns_s, 3 * 0.2 + 3 * 0.8, 1e-9);
}

// The flash recycles from 0.6 to 4.6 s, the operator is waited for from 1.8 to 29.4 s: 1.2 s of it count.
TEST(Timeline, LeavesOutTheOperator) {
  SessionTimeline timeline{{Frame(1, 0.6, 0.0), Frame(2, 30.0, 29.4)}, {{1.8, 29.4}}};
  timeline.frames[1].ready = {1.7, 2.0};  // set while the operator is busy: 0.1 s of it count
  const ChainTimes c = AddUp(timeline);
  EXPECT_NEAR(c.camera_s, 2 * (0.2 + 0.8) + 0.1, 1e-9);
  EXPECT_NEAR(c.flash_s, 1.2, 1e-9);
  EXPECT_NEAR(c.taken_s, 31.2 - 27.6, 1e-9);
}

TEST(Timeline, OfNothingIsNothing) {
  EXPECT_EQ(AddUp({}).taken_s, 0.0);
  EXPECT_EQ(AddUp({}).overhead(), 0.0);
}

// A frame that was lost has no end of its fetching.
TEST(Timeline, CountsNothingForWhatNeverEnded) {
  FrameTiming lost = Frame(1, 0.6, 0.0);
  lost.fetch = {0.8, 0.0};
  EXPECT_NEAR(AddUp({{lost}, {}}).camera_s, 0.2, 1e-9);
}

TEST(Timeline, IsDrawn) {
  const std::string svg = TimelineSvg({{Frame(1, 0.6, 0.0), Frame(2, 4.6, 0.9)}, {{2.0, 3.0}}});
  EXPECT_THAT(svg, testing::StartsWith("<svg"));
  EXPECT_THAT(svg, testing::HasSubstr("fetch 2: 0.800 s"));
  EXPECT_THAT(svg, testing::EndsWith("</svg>\n"));
}

}  // namespace
}  // namespace dermap
