// SPDX-License-Identifier: Apache-2.0
// The order of frames, by hand.
#include "acquire/schedule.h"

#include <gtest/gtest.h>

#include "common/core/error.h"
#include "tests/acquire/support.h"

namespace dermap {
namespace {

PlanConfig TwoFilters() {
  PlanConfig plan;
  plan.exposures = {{1, 10.0, 100}, {2, 10.0, 100}};
  return plan;
}

TEST(Schedule, OneBlackFrameForSettingsThatAreTheSame) {
  const auto schedule = MakeSchedule(acquire_test::SmallRig(), TwoFilters());
  ASSERT_EQ(schedule.size(), 5u);  // 1 black, 2 Spectralon, 2 skin
  EXPECT_EQ(schedule[0].role, FrameRole::kBlack);
  EXPECT_EQ(schedule[0].slot, 3);
  EXPECT_EQ(schedule[0].wavelength_nm, 0.0);
  EXPECT_EQ(schedule[4].number, 5);
}

TEST(Schedule, GoesThroughAllFiltersBeforeItRepeatsOne) {
  PlanConfig plan = TwoFilters();
  plan.skin_frames = 2;
  plan.black_frames = 0;
  const auto schedule = MakeSchedule(acquire_test::SmallRig(), plan);
  ASSERT_EQ(schedule.size(), 6u);
  EXPECT_EQ(schedule[2].wavelength_nm, 540.0);
  EXPECT_EQ(schedule[3].wavelength_nm, 650.0);
  EXPECT_EQ(schedule[4].wavelength_nm, 540.0);
}

TEST(Schedule, RefusesAPlanThatTheRigCannotTake) {
  PlanConfig plan = TwoFilters();
  plan.exposures[0].slot = 3;  // the opaque one
  EXPECT_THROW(MakeSchedule(acquire_test::SmallRig(), plan), InputError);
  RigConfig rig = acquire_test::SmallRig();
  rig.slots.pop_back();
  EXPECT_THROW(MakeSchedule(rig, TwoFilters()), InputError);
}

// The shipped plan fits the shipped rig: black frames for 100, 125, 160 and 250 ISO and two times eight
// filters.
TEST(Schedule, ShippedPlanFitsTheShippedRig) {
  const RigConfig rig = ReadRig(ConfigDirectory() / "rigs/simulated_8band.toml");
  const auto schedule = MakeSchedule(rig, ReadPlan(ConfigDirectory() / "plans/standard.toml"));
  EXPECT_EQ(schedule.size(), 20u);
}

// Black frames of two ISO are 1 and 2, Spectralon is 3 and 4, skin 5 and 6; 7 is black, of a changed
// exposure.
TEST(Schedule, TakesOneBlackFrameFirstAndTheOthersWhereTheWheelPasses) {
  const RigConfig rig = acquire_test::SmallRig();
  PlanConfig plan = TwoFilters();
  plan.exposures[1].iso = 160;
  auto schedule = MakeSchedule(rig, plan);
  AddBlackFrames({10.0, 250}, 1, rig, schedule);
  const auto numbers = [&](bool turned_by_hand) {
    std::vector<int> order;
    for (const FrameRecord& f : InOrderOfTaking(schedule, turned_by_hand)) order.push_back(f.number);
    return order;
  };
  EXPECT_EQ(numbers(false), (std::vector{1, 3, 4, 2, 7, 5, 6}));
  EXPECT_EQ(numbers(true), (std::vector{1, 2, 7, 3, 4, 5, 6}));
}

// Two filters at ISO 100 and 160; the second's skin frames go to 125, then both its roles to 250.
TEST(Schedule, TakesAChangedFilterAtItsNewIsoWithBlackFramesOfItsOwn) {
  const RigConfig rig = acquire_test::SmallRig();
  PlanConfig plan = TwoFilters();
  plan.exposures[1].iso = 160;
  auto schedule = MakeSchedule(rig, plan);  // black 100, black 160, Spectralon 1 and 2, skin 1 and 2
  ASSERT_EQ(schedule.size(), 6u);
  EXPECT_TRUE(SettingsWithoutBlack(schedule, schedule).empty());
  ApplyExposureChange({FrameRole::kSkin, 2, 160, 125, 6, "", ""}, schedule);
  EXPECT_EQ(schedule[3].iso, 160);
  EXPECT_EQ(schedule[5].iso, 125);
  ApplyExposureChange({FrameRole::kSpectralon, 2, 160, 250, 4, "", ""}, schedule);
  EXPECT_EQ(schedule[1].iso, 160) << "a black frame is of no filter";
  EXPECT_EQ(schedule[2].iso, 100);
  EXPECT_EQ(schedule[3].iso, 250);
  EXPECT_EQ(schedule[5].iso, 250);
  const auto lacking = SettingsWithoutBlack(schedule, schedule);
  ASSERT_EQ(lacking.size(), 1u);
  EXPECT_EQ(lacking[0].iso, 250);
  AddBlackFrames(lacking[0], 2, rig, schedule);
  ASSERT_EQ(schedule.size(), 8u);
  EXPECT_EQ(schedule[7].number, 8);
  EXPECT_EQ(schedule[7].slot, 3);
  EXPECT_EQ(schedule[7].wavelength_nm, 0.0);
  EXPECT_TRUE(SettingsWithoutBlack(schedule, schedule).empty());
}

TEST(Schedule, FingerprintTellsPlansApart) {
  const RigConfig rig = acquire_test::SmallRig();
  PlanConfig plan = TwoFilters();
  const std::string print = Fingerprint(rig, MakeSchedule(rig, plan));
  EXPECT_EQ(print, Fingerprint(rig, MakeSchedule(rig, plan)));
  plan.exposures[1].iso = 125;
  EXPECT_NE(print, Fingerprint(rig, MakeSchedule(rig, plan)));
}

}  // namespace
}  // namespace dermap
