// SPDX-License-Identifier: Apache-2.0
// The forward model on the skin of the recorded sample that Monte Carlo lit: freckles over a vein, in the
// window.
#include <gtest/gtest.h>

#include <cmath>

#include "acquire/simulated/patch_reflectance.h"
#include "common/files/stack.h"
#include "common/transport/forward_model.h"

namespace dermap {
namespace {

struct Misfit {
  double rms = 0.0, noise = 0.0, mean = 0.0;  // of rendered / judged - 1, over the cells
};

Misfit Compare(const PlaneF& rendered, const PlaneF& judged, const PlaneF& sigma) {
  const int cells = judged.width(), side = rendered.width() / cells;
  const double count = cells * cells, area = side * side;
  Misfit misfit;
  for (int y = 0; y < cells; ++y) {
    for (int x = 0; x < cells; ++x) {
      double sum = 0.0;
      for (int row = y * side; row < (y + 1) * side; ++row)
        for (int column = x * side; column < (x + 1) * side; ++column) sum += rendered(column, row);
      const double error = sum / area / judged(x, y) - 1.0, noise = sigma(x, y) / judged(x, y);
      misfit.rms += error * error / count;
      misfit.noise += noise * noise / count;
      misfit.mean += error / count;
    }
  }
  misfit.rms = std::sqrt(misfit.rms);
  misfit.noise = std::sqrt(misfit.noise);
  return misfit;
}

// Source: 2e7 photons a band, scripts/make_monte_carlo_sample. Asked is an rms of 2 % more than the judge's
// noise; found were at most 0.6 % beyond it, and a mean within 0.2 %. The coupling of [D08 4.1] is 1.5 to 2.9
// % off.
TEST(MonteCarloSample, IsWhatTheForwardModelSays) {
  const RigConfig rig = ReadRig(ConfigDirectory() / "rigs" / "simulated_8lines.toml");
  const Scene scene = ReadScene(ConfigDirectory() / "scenes" / "monte_carlo_skin.toml", rig.window_mm);
  const ReflectanceStack judge = ReadReflectanceStack(scene.reflectance);
  ASSERT_EQ(judge.bands.size(), 8u);
  const Chromophores chromophores(ConfigDirectory() / "spectra");
  const auto exact = MakeProfileSource("exact");
  ImagingConditions conditions = ConditionsOfRig(rig);
  conditions.geometry = judge.geometry;
  ForwardOptions gather;
  gather.coupling = Coupling::kGather;
  const auto rendered =
      ForwardModel(chromophores, *exact, scene.tissue, judge.bands, conditions, {}).Render(scene.maps);
  const auto gathered =
      ForwardModel(chromophores, *exact, scene.tissue, judge.bands, conditions, gather).Render(scene.maps);
  for (std::size_t b = 0; b < judge.bands.size(); ++b) {
    const Misfit misfit = Compare(rendered[b], judge.reflectance[b], judge.sigma[b]);
    EXPECT_LT(misfit.noise, 0.02);
    EXPECT_LT(misfit.rms, std::hypot(misfit.noise, 0.01)) << judge.bands[b].wavelength_nm;
    EXPECT_LT(std::abs(misfit.mean), 0.004) << judge.bands[b].wavelength_nm;
    EXPECT_GT(Compare(gathered[b], judge.reflectance[b], judge.sigma[b]).rms, std::hypot(misfit.noise, 0.012))
        << judge.bands[b].wavelength_nm;
  }
}

}  // namespace
}  // namespace dermap
