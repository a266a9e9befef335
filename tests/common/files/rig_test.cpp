// SPDX-License-Identifier: Apache-2.0
#include "common/files/rig.h"

#include <gmock/gmock.h>

#include "tests/common/files/temporary_folder.h"

namespace dermap {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr const char* kRig = R"(name = "bench"
[camera]
driver = "simulated"
[wheel]
driver = "simulated"
[[wheel.slot]]
slot = 2
wavelength_nm = 450
fwhm_nm = 8.5
[[wheel.slot]]
slot = 1
wavelength_nm = 540
[[wheel.slot]]
slot = 9
opaque = true
[geometry]
window_mm = 10
[references]
gray_card_reflectance = 0.18
gray_card_region = [0.1, 0.2, 0.3, 0.4]
)";

class RigTest : public testing::Test {
 protected:
  RigConfig Rig(const std::string& text) { return ReadRig(folder_.Write("rig.toml", text)); }
  PlanConfig Plan(const std::string& text) { return ReadPlan(folder_.Write("plan.toml", text)); }
  std::string RigSentence(const std::string& text) {
    return SentenceOf<InputError>([&] { Rig(text); });
  }
  std::string PlanSentence(const std::string& text) {
    return SentenceOf<InputError>([&] { Plan(text); });
  }
  TemporaryFolder folder_;
};

// docs/formats.md: keys and defaults; slots come back in order. 7.5 mm and 30 degrees are [D08 6.2]'s.
TEST_F(RigTest, ReadsARigAndItsDefaults) {
  const RigConfig rig = Rig(kRig);
  EXPECT_EQ(rig.name, "bench");
  ASSERT_EQ(rig.slots.size(), 3u);
  EXPECT_EQ(rig.slots[0].slot, 1);
  EXPECT_DOUBLE_EQ(rig.slots[0].wavelength_nm, 540);
  EXPECT_DOUBLE_EQ(rig.slots[0].fwhm_nm, 10);
  EXPECT_DOUBLE_EQ(rig.slots[1].fwhm_nm, 8.5);
  EXPECT_TRUE(rig.slots[2].opaque);
  EXPECT_DOUBLE_EQ(rig.slots[2].wavelength_nm, 0);
  EXPECT_DOUBLE_EQ(rig.window_mm, 10);
  EXPECT_DOUBLE_EQ(rig.view_angle_deg, 30);
  EXPECT_DOUBLE_EQ(rig.light_angle_deg, 0);
  EXPECT_DOUBLE_EQ(rig.gray_card_reflectance, 0.18);
  EXPECT_THAT(rig.gray_card_region, ElementsAre(0.1, 0.2, 0.3, 0.4));
  EXPECT_EQ(FindOpaqueSlot(rig)->slot, 9);
  EXPECT_EQ(FindSlot(rig, 2)->wavelength_nm, 450);
  EXPECT_EQ(FindSlot(rig, 3), nullptr);
  EXPECT_DOUBLE_EQ(Rig("[wheel]\n[[wheel.slot]]\nslot = 1\nwavelength_nm = 600\n").window_mm, 7.5);
  EXPECT_EQ(Rig("[wheel]\n[[wheel.slot]]\nslot = 1\nwavelength_nm = 600\n").name, "rig")
      << "the file's own name";
}

// Each mistake is told with its line.
TEST_F(RigTest, RejectsWheelsThatCannotBe) {
  const std::string slot = "[wheel]\n[[wheel.slot]]\nslot = 1\nwavelength_nm = 450\n";
  EXPECT_THAT(RigSentence(slot + "[[wheel.slot]]\nslot = 1\nwavelength_nm = 500\n"),
              AllOf(HasSubstr("line 6"), HasSubstr("slot 1 is given twice")));
  EXPECT_THAT(RigSentence("[wheel]\n[[wheel.slot]]\nslot = 1\nwavelength_nm = 1064\n"),
              HasSubstr("from 350 to 1000"));
  EXPECT_THAT(RigSentence("[wheel]\n[[wheel.slot]]\nslot = 0\nwavelength_nm = 450\n"),
              HasSubstr("from 1 to 64"));
  EXPECT_THAT(RigSentence("[wheel]\n[[wheel.slot]]\nslot = 1\n"), HasSubstr("wavelength_nm' is missing"));
  EXPECT_THAT(RigSentence("[wheel]\n[[wheel.slot]]\nslot = 1\nopaque = true\nwavelength_nm = 450\n"),
              HasSubstr("is opaque and has 'wavelength_nm'"));
  EXPECT_THAT(
      RigSentence(slot +
                  "[[wheel.slot]]\nslot = 2\nopaque = true\n[[wheel.slot]]\nslot = 3\nopaque = true\n"),
      HasSubstr("a second opaque slot"));
  EXPECT_THAT(RigSentence("[wheel]\n[[wheel.slot]]\nslot = 3\nopaque = true\n"),
              HasSubstr("no filter in the wheel"));
  EXPECT_THAT(RigSentence("name = 'x'\n"), HasSubstr("[wheel] is missing"));
  EXPECT_THAT(RigSentence(slot + "wavelenght_nm = 3\n"), HasSubstr("did you mean 'wavelength_nm'?"));
  EXPECT_THAT(RigSentence(slot + "[refrences]\n"), HasSubstr("did you mean 'references'?"));
  EXPECT_THAT(RigSentence(slot + "[references]\ngray_card_region = [0.8, 0.2, 0.3, 0.3]\n"),
              HasSubstr("not a rectangle in the frame"));
}

// A rig's files: beside it first, then in the config directory; a scene that is nowhere names both places.
TEST_F(RigTest, FindsItsFilesBesideItFirst) {
  const std::string wheel = "[wheel]\n[[wheel.slot]]\nslot = 1\nwavelength_nm = 450\n";
  folder_.Write("scene.toml", "");
  folder_.Write("own.csv", "");
  const RigConfig rig =
      Rig(wheel + "[references]\nspectralon_csv = 'own.csv'\n[simulated]\nscene = 'scene.toml'\n");
  EXPECT_TRUE(std::filesystem::equivalent(rig.simulated_scene, folder_ / "scene.toml"));
  EXPECT_TRUE(rig.spectralon_csv.is_absolute());
  EXPECT_EQ(Rig(wheel).spectralon_csv, "spectra/spectralon_99_labsphere.csv");
  EXPECT_THAT(RigSentence(wheel + "[simulated]\nscene = 'scenes/none.toml'\n"),
              AllOf(HasSubstr("neither beside the rig file nor at"), HasSubstr("config/scenes/none.toml")));
}

// docs/formats.md; 1/100 s at ISO 400 is [D08 6.2]'s exposure.
TEST_F(RigTest, ReadsAPlanAndItsDefaults) {
  const PlanConfig plan = Plan(
      "subject = 'S01'\nskin_frames = 2\n[[exposure]]\nslot = 3\n[[exposure]]\nslot = 1\n"
      "exposure_ms = 20\niso = 100\n");
  EXPECT_EQ(plan.subject, "S01");
  EXPECT_EQ(plan.black_frames, 1);
  EXPECT_EQ(plan.skin_frames, 2);
  ASSERT_EQ(plan.exposures.size(), 2u);
  EXPECT_EQ(plan.exposures[0].slot, 3) << "the plan's own order";
  EXPECT_DOUBLE_EQ(plan.exposures[0].exposure_ms, 10);
  EXPECT_EQ(plan.exposures[0].iso, 400);
  EXPECT_EQ(plan.exposures[1].iso, 100);
}

// Each mistake is told with its line.
TEST_F(RigTest, RejectsPlansThatCannotBe) {
  EXPECT_THAT(PlanSentence("subject = 'S01'\n"), HasSubstr("nothing to take"));
  EXPECT_THAT(PlanSentence("[[exposure]]\nslot = 1\n[[exposure]]\nslot = 1\n"),
              AllOf(HasSubstr("line 4"), HasSubstr("planned twice")));
  EXPECT_THAT(PlanSentence("[[exposure]]\nslot = 1\nexposure = 10\n"),
              HasSubstr("did you mean 'exposure_ms'?"));
  EXPECT_THAT(PlanSentence("skin_frames = 0\n[[exposure]]\nslot = 1\n"), HasSubstr("skin_frames"));
}

// A plan fits a rig whose filters it names; black frames need the opaque slot.
TEST_F(RigTest, ChecksAPlanAgainstARig) {
  const RigConfig rig = Rig(kRig);
  EXPECT_NO_THROW(CheckPlan(rig, Plan("[[exposure]]\nslot = 1\n")));
  EXPECT_THAT(SentenceOf<InputError>([&] { CheckPlan(rig, Plan("[[exposure]]\nslot = 4\n")); }),
              AllOf(HasSubstr("slot 4, which does not exist"), HasSubstr("1, 2")));
  EXPECT_THAT(SentenceOf<InputError>([&] { CheckPlan(rig, Plan("[[exposure]]\nslot = 9\n")); }),
              HasSubstr("is the opaque one"));
  const RigConfig open = Rig("[wheel]\n[[wheel.slot]]\nslot = 1\nwavelength_nm = 600\n");
  EXPECT_THAT(SentenceOf<InputError>([&] { CheckPlan(open, Plan("[[exposure]]\nslot = 1\n")); }),
              HasSubstr("no opaque slot"));
  EXPECT_NO_THROW(CheckPlan(open, Plan("black_frames = 0\n[[exposure]]\nslot = 1\n")));
}

}  // namespace
}  // namespace dermap
