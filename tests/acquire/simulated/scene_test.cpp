// SPDX-License-Identifier: Apache-2.0
// Scenes: the shipped ones, their features, and bad ones.
#include "acquire/simulated/scene.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "common/core/error.h"
#include "common/transport/band_optics.h"
#include "tests/acquire/support.h"

namespace dermap {
namespace {

using acquire_test::TemporaryFolder;

std::string MessageOf(const TemporaryFolder& folder, const std::string& text) {
  try {
    ReadScene(folder.Write("scene.toml", text), 7.5);
  } catch (const InputError& e) {
    return e.what();
  }
  return "no error";
}

std::vector<float> Sorted(const PlaneF& plane) {
  std::vector<float> v(plane.values().begin(), plane.values().end());
  std::sort(v.begin(), v.end());
  return v;
}

// The bounds of [D08 table 1]; and no map may jump between pixels by more than a soft edge does: the steepest
// of smoothstep is 1.5/edge, here over 0.2 mm with 0.0293 mm a pixel, a fifth of the map's range.
TEST(Scene, ShippedScenesAreInsideTable1AndSmooth) {
  for (const char* name : {"light_freckles", "medium_vein"}) {
    const Scene scene = ReadScene(ConfigDirectory() / "scenes" / (std::string(name) + ".toml"), 7.5);
    ASSERT_FALSE(scene.pattern);
    for (int k = 0; k < kParameterCount; ++k) {
      const auto& info = kParameters[static_cast<std::size_t>(k)];
      const PlaneF& plane = scene.maps.planes[static_cast<std::size_t>(k)];
      ASSERT_TRUE(plane.SameShape(kPatchSize_px, kPatchSize_px));
      const auto sorted = Sorted(plane);
      EXPECT_GT(sorted.front(), info.lower)
          << name << ' ' << info.name;  // not at a bound: nothing was cut off
      EXPECT_LT(sorted.back(), info.upper) << name << ' ' << info.name;
      EXPECT_GT(sorted.back() - sorted.front(), 0.1 * sorted[sorted.size() / 2])
          << "no variation in " << info.name;
      float step = 0.0f;
      for (int y = 0; y < kPatchSize_px; ++y) {
        for (int x = 0; x + 1 < kPatchSize_px; ++x)
          step = std::max(step, std::abs(plane(x + 1, y) - plane(x, y)));
      }
      EXPECT_LT(step, 0.25f * (sorted.back() - sorted.front())) << name << ' ' << info.name;
    }
  }
}

// What the scenes' own files say of themselves: light skin of C_m 0.02 to 0.03 with freckles up to about
// 0.12; a vein that adds 0.07 to the dermis's blood of 0.02.
TEST(Scene, ShippedScenesHoldWhatTheyPromise) {
  const auto light =
      Sorted(ReadScene(ConfigDirectory() / "scenes/light_freckles.toml", 7.5).maps[Parameter::kC_m]);
  EXPECT_NEAR(light[light.size() * 3 / 10], 0.025, 0.005);
  EXPECT_GT(light.back(), 0.08);
  EXPECT_LT(light.back(), 0.14);
  const auto vein =
      Sorted(ReadScene(ConfigDirectory() / "scenes/medium_vein.toml", 7.5).maps[Parameter::kC_hd]);
  EXPECT_NEAR(vein[vein.size() / 2], 0.02, 0.006);
  EXPECT_NEAR(vein[vein.size() * 97 / 100], 0.09, 0.008);
}

TEST(Scene, SeedDecidesTheMaps) {
  const TemporaryFolder folder;
  const auto maps = [&](int seed) {
    const auto path =
        folder.Write("s.toml", "seed = " + std::to_string(seed) + "\n[C_m]\nvalue = 0.1\namplitude = 0.01\n");
    return Sorted(ReadScene(path, 7.5).maps[Parameter::kC_m]);
  };
  EXPECT_EQ(maps(1), maps(1));
  EXPECT_NE(maps(1), maps(2));
}

// A straight vein of 1 mm with an edge of 0.5 mm across a window of 7.5 mm: its profile integrates to amount
// x width.
TEST(Scene, AVeinHoldsItsWidth) {
  const TemporaryFolder folder;
  const Scene scene = ReadScene(folder.Write("s.toml",
                                             "[C_hd]\nvalue = 0.02\n[[vein]]\npoints_mm = [-1, 3, 9, 3]\n"
                                             "width_mm = 1.0\nedge_mm = 0.5\nC_hd = 0.04\n"),
                                7.5);
  const PlaneF& blood = scene.maps[Parameter::kC_hd];
  double sum = 0.0;
  for (int y = 0; y < kPatchSize_px; ++y) sum += blood(100, y) - 0.02;
  EXPECT_NEAR(sum * 7.5 / kPatchSize_px, 0.04 * 1.0, 1e-4);
  EXPECT_NEAR(blood(100, 102), 0.06, 1e-5);  // y = 3 mm
  EXPECT_NEAR(blood(100, 200), 0.02, 1e-6);
}

// [D08 5.3]: 0.0175 at the junction, and what a tattoo adds on top of it.
TEST(Scene, ATattooAddsToTheJunctionsAbsorbance) {
  const TemporaryFolder folder;
  const Scene scene = ReadScene(
      folder.Write(
          "s.toml",
          "[[tattoo]]\npoints_mm = [2, -1, 2, 9]\nwidth_mm = 1.0\nedge_mm = 0.2\nabsorbance = 0.8\n"),
      7.5);
  ASSERT_EQ(scene.maps.junction_absorbance.size(), 1u);
  EXPECT_NEAR(scene.maps.junction_absorbance[0](68, 100), 0.8175, 1e-5);
  EXPECT_NEAR(scene.maps.junction_absorbance[0](200, 100), 0.0175, 1e-6);
}

TEST(Scene, BadScenesAreRefusedByName) {
  using testing::HasSubstr;
  const TemporaryFolder folder;
  EXPECT_THAT(MessageOf(folder, "flat_reflectanse = 0.5\n"), HasSubstr("flat_reflectance"));
  EXPECT_THAT(MessageOf(folder, "[bench]\nvigneting = 0.5\n"), HasSubstr("vignetting"));
  EXPECT_THAT(MessageOf(folder, "[bench]\neffects = \"none\"\n"), HasSubstr("ideal"));
  EXPECT_THAT(MessageOf(folder, "[bench]\nwidth_px = 481\n"), HasSubstr("even"));
  EXPECT_THAT(MessageOf(folder, "[C_m]\nvalue = 0.7\n"), HasSubstr("value"));
  EXPECT_THAT(MessageOf(folder, "[[vein]]\npoints_mm = [1, 2, 3]\nC_hd = 0.1\n"), HasSubstr("3 numbers"));
  EXPECT_THAT(MessageOf(folder, "flat_reflectance = 0.5\n[pattern]\nkind = \"checker\"\nlow = 0\nhigh = 1\n"),
              HasSubstr("both"));
  EXPECT_THAT(MessageOf(folder, "[pattern]\nkind = \"stripes\"\nlow = 0\nhigh = 1\n"), HasSubstr("checker"));
  EXPECT_THAT(MessageOf(folder, "profiles = \"guess\"\n"), HasSubstr("multipole"));
}

}  // namespace
}  // namespace dermap
