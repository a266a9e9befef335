// SPDX-License-Identifier: Apache-2.0
// truth/ holds what the frames were made from.
#include "acquire/simulated/truth.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "common/files/atomic_file.h"
#include "common/files/maps.h"
#include "common/files/stack.h"
#include "tests/acquire/support.h"

namespace dermap {
namespace {

// The bench that the files were written from is the truth.
TEST(Truth, HoldsMapsReflectanceAndEveryShot) {
  const acquire_test::TemporaryFolder folder;
  RigConfig rig = acquire_test::SmallRig();
  rig.slots = {{1, 540.0, 10.0, false}};
  const OpticalBench bench(rig, ReadScene(ConfigDirectory() / "scenes/light_freckles.toml", rig.window_mm));
  std::vector<FrameRecord> schedule(2);
  schedule[0].number = 1;
  schedule[0].role = FrameRole::kSpectralon;
  schedule[1].number = 2;
  schedule[1].role = FrameRole::kSkin;
  WriteTruth(folder.path() / "truth", bench, schedule);

  const MapsFile maps = ReadMaps(folder.path() / "truth/maps.exr");
  EXPECT_NEAR(maps.pixel_size_mm.value(), 7.5 / 256, 1e-6);
  EXPECT_EQ(maps.geometry, Geometry::kFactor0_30);
  ASSERT_EQ(maps.bands.size(), 1u);
  EXPECT_EQ(maps.bands[0].wavelength_nm, 540.0);
  EXPECT_EQ(maps.maps[Parameter::kC_m](100, 37), bench.scene().maps[Parameter::kC_m](100, 37));
  const ReflectanceStack stack = ReadReflectanceStack(folder.path() / "truth/reflectance.exr");
  EXPECT_EQ(stack.reflectance[0](100, 37), bench.patch().Mean()[0](100, 37));
  EXPECT_NEAR(stack.bands[0].fwhm_nm, 10.0, 1e-6);

  const auto json = nlohmann::json::parse(ReadTextFile(folder.path() / "truth/bench.json"));
  EXPECT_EQ(json["seed"], 2008);
  EXPECT_EQ(json["bench"]["flash_drift"], 0.02);
  ASSERT_EQ(json["shots"].size(), 2u);
  EXPECT_NEAR(json["shots"][0]["flash"].get<double>(), bench.FlashFactor(1), 1e-12);
  const auto corners = bench.CornersOfShot({FrameRole::kSkin, 1, 10.0, 100, 2});
  EXPECT_NEAR(json["shots"][1]["window_corners_px"][2][0].get<double>(), corners[2].x, 1e-9);
}

// The paper's spectra at work: skin is redder than green through this bench, more so than a gray patch, and
// its reflectance factor lies between 0.02 (a freckle in green light) and 0.8.
TEST(Truth, SkinIsPlausible) {
  RigConfig rig = acquire_test::SmallRig();
  const OpticalBench bench(rig, ReadScene(ConfigDirectory() / "scenes/light_freckles.toml", rig.window_mm));
  const auto mean = bench.patch().Mean();
  const float green = mean[0](128, 128), red = mean[1](128, 128);
  EXPECT_GT(red, 1.3f * green);
  for (const PlaneF& plane : mean) {
    for (const float v : plane.values()) {
      ASSERT_GT(v, 0.02f);
      ASSERT_LT(v, 0.8f);
    }
  }
}

}  // namespace
}  // namespace dermap
