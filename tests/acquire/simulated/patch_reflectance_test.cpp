// SPDX-License-Identifier: Apache-2.0
// What the patch reflects through the filters.
#include "acquire/simulated/patch_reflectance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "common/files/stack.h"
#include "common/transport/forward_model.h"
#include "tests/acquire/support.h"

namespace dermap {
namespace {

RigConfig OneBandRig(double wavelength_nm) {
  RigConfig rig = acquire_test::SmallRig();
  rig.slots = {{1, wavelength_nm, 10.0, false}};
  return rig;
}

// The definition of what a filter passes: an integral over its Gaussian, here by a trapezoid of nine steps
// (which for a Gaussian of this spacing is exact to 1e-12 beside the tails beyond three sigma, 0.3 %). At 585
// nm, where blood's spectrum falls steeply and the filter's width matters most.
TEST(PatchReflectance, MeanIsTheIntegralOverTheFilter) {
  const RigConfig rig = OneBandRig(585.0);
  const Scene scene = ReadScene(ConfigDirectory() / "scenes/medium_vein.toml", rig.window_mm);
  const PatchReflectance patch = RenderPatch(scene, rig);
  const PlaneF mean = patch.Mean()[0];

  const double sigma_nm = 10.0 / (2.0 * std::sqrt(2.0 * std::log(2.0)));
  std::vector<Band> lines;
  std::vector<double> weights;
  for (int i = -4; i <= 4; ++i) {
    lines.push_back({585.0 + 0.75 * i * sigma_nm, 0.0});
    weights.push_back(std::exp(-0.5 * 0.75 * 0.75 * i * i));
  }
  const double total = std::accumulate(weights.begin(), weights.end(), 0.0);
  const Chromophores chromophores(ConfigDirectory() / "spectra");
  const auto source = MakeProfileSource(scene.profiles);
  const ForwardModel model(chromophores, *source, scene.tissue, lines, patch.conditions, ForwardOptions{});
  const std::vector<PlaneF> planes = model.Render(scene.maps);
  double largest = 0.0;
  for (std::size_t i = 0; i < mean.size(); i += 7) {
    double expected = 0.0;
    for (std::size_t n = 0; n < lines.size(); ++n) expected += weights[n] / total * planes[n].values()[i];
    largest = std::max(largest, std::abs(mean.values()[i] / expected - 1.0));
  }
  EXPECT_LT(largest, 6e-4);
  // And the filter's width does matter here: its centre alone would be further off.
  EXPECT_GT(std::abs(planes[4](128, 128) / mean(128, 128) - 1.0f), 1e-3f);
}

// Light that was judged in cells reaches the bench as it was judged: the mean over each cell is the stack's.
TEST(PatchReflectance, StackOfCellsKeepsTheirMeans) {
  const RigConfig rig = ReadRig(ConfigDirectory() / "rigs" / "simulated_8lines.toml");
  const Scene scene = ReadScene(ConfigDirectory() / "scenes" / "monte_carlo_skin.toml", rig.window_mm);
  const ReflectanceStack judged = ReadReflectanceStack(scene.reflectance);
  const PatchReflectance patch = RenderPatch(scene, rig);
  const PlaneF& cells = judged.reflectance[3];
  const int side = kPatchSize_px / cells.width();
  const PlaneF mean = patch.Mean()[3];
  double lowest = 1e9, highest = 0.0;
  for (int y = 0; y < cells.height(); ++y)
    for (int x = 0; x < cells.width(); ++x) {
      double sum = 0.0;
      for (int row = y * side; row < (y + 1) * side; ++row)
        sum += std::accumulate(mean.Row(row) + x * side, mean.Row(row) + (x + 1) * side, 0.0);
      const double ratio = sum / (side * side) / cells(x, y);
      lowest = std::min(lowest, ratio);
      highest = std::max(highest, ratio);
    }
  EXPECT_NEAR(highest / lowest, 1.0, 1e-4);  // one factor: that of the rig's geometry
}

// A test pattern reflects the same at every wavelength, by definition.
TEST(PatchReflectance, PatternsAreGray) {
  const Scene scene = acquire_test::FlatScene(0.42, BenchConfig{});
  const PatchReflectance patch = RenderPatch(scene, acquire_test::SmallRig());
  ASSERT_EQ(patch.bands.size(), 2u);
  for (const auto& nodes : patch.nodes) {
    for (const PlaneF& plane : nodes) EXPECT_EQ(plane(17, 200), 0.42f);
  }
  EXPECT_NEAR(patch.Mean()[1](5, 5), 0.42, 1e-6);
  EXPECT_EQ(patch.conditions.geometry, Geometry::kFactor0_30);
  EXPECT_NEAR(patch.conditions.pixel_size_mm, 7.5 / 256, 1e-12);
}

}  // namespace
}  // namespace dermap
