// SPDX-License-Identifier: Apache-2.0
// What the engine chooses for a tolerance, and whether it knows how far it is off.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "common/transport/forward_model.h"
#include "tests/common/transport/scenes.h"

namespace dermap {
namespace {

// A scene of random kind: uniform, freckled, striped or noise, anywhere in table 1.
ParameterMaps RandomScene(int size, std::mt19937& random) {
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * static_cast<double>(random()) / 4294967296.0;
  };
  ParameterVector p;
  for (int k = 0; k < kParameterCount; ++k) {
    const double share =
        k == static_cast<int>(Parameter::kBeta_m) ? uniform(0.2, 1.0) : std::pow(uniform(0.05, 1.0), 2);
    p[k] = share * kParameters[k].upper;
  }
  ParameterMaps maps(size, size, p);
  const int kind = static_cast<int>(random() % 4);
  const double contrast = uniform(0.02, 0.9), period = uniform(4.0, 60.0);
  const PlaneF noise = Noise(size, size, random(), -1.0f, 1.0f);
  for (int y = 0; y < size; ++y) {
    for (int x = 0; x < size; ++x) {
      double change = 0.0;
      if (kind == 1) change = std::hypot(x - 0.4 * size, y - 0.6 * size) < 0.2 * size ? 1.0 : -1.0;
      if (kind == 2) change = std::sin(2.0 * 3.14159265 * x / period);
      if (kind == 3) change = noise(x, y);
      maps[Parameter::kC_m](x, y) *= static_cast<float>(1.0 + contrast * change);
      maps[Parameter::kC_hd](x, y) *= static_cast<float>(1.0 - 0.5 * contrast * change);
    }
  }
  return maps;
}

// Source: the same engine, its every approximation far finer: a hundredth of the tolerance, 4 mm of skin, 20
// terms. The estimate is never below a third of the truth, and the tolerance is kept.
TEST(BandChoice, KnowsHowFarItIsOff) {
  const Band bands[] = {{450.0, 0.0}, {560.0, 0.0}, {700.0, 0.0}};
  std::mt19937 random(11);

  for (int scene = 0; scene < 16; ++scene) {
    const int size = std::array{48, 48, 96, 130}[random() % 4];
    const auto conditions = Conditions(size, random() % 3 ? Illumination::kWindow : Illumination::kUniform);
    const ParameterMaps maps = RandomScene(size, random);
    ForwardOptions fine, options;
    fine.tolerance = 1e-5;
    fine.margin_mm = 4.0;
    fine.terms = 20;
    options.tolerance = std::array{3e-4, 1e-3, 3e-3, 1e-2}[random() % 4];
    const auto truth = Model(bands, conditions, fine, "exact").Render(maps);
    std::vector<BandChoice> choices;
    const auto found = Model(bands, conditions, options, "exact").Render(maps, {}, &choices);
    for (int b = 0; b < 3; ++b) {
      const double error = Compare(found[b], truth[b]).relative_rms;
      EXPECT_GT(choices[b].error, error / 3.0)
          << "scene " << scene << ", band " << b << ": " << choices[b].why;
      EXPECT_LT(error, 1.5 * std::max(options.tolerance, 4e-4))
          << "scene " << scene << ", band " << b << ": " << choices[b].why;
    }
  }
}

// Source: the definition of the rungs. Uniform skin under light that goes on needs no transport; a lit window
// needs one kernel; freckles need more.
TEST(BandChoice, TakesNoMoreThanASceneNeeds) {
  const Band bands[] = {{560.0, 0.0}};
  const ParameterMaps uniform(64, 64, AverageSkin());
  std::vector<BandChoice> choices;
  const ForwardModel wide = Model(bands, Conditions(64, Illumination::kUniform), {}, "exact");
  const ForwardModel window = Model(bands, Conditions(64, Illumination::kWindow), {}, "exact");
  const auto local = wide.Render(uniform, {}, &choices);
  EXPECT_EQ(choices[0].rung, Rung::kLocal);
  EXPECT_NEAR(local[0](3, 5), wide.LocalReflectance(0, AverageSkin(), TissueConfig{}.junction_absorbance),
              1e-5);
  ImagingConditions huge = Conditions(64, Illumination::kUniform);
  huge.pixel_size_mm = 2000.0;  // no light goes from one pixel to the next
  ForwardOptions exact;
  exact.tolerance = 1e-4;
  Model(bands, huge, exact, "exact").Render(FreckledSkin(64, 2), {}, &choices);
  EXPECT_EQ(choices[0].rung, Rung::kLocal);
  window.Render(uniform, {}, &choices);
  EXPECT_EQ(choices[0].rung, Rung::kHomogeneous);
  window.Render(FreckledSkin(64, 2), {}, &choices);
  EXPECT_EQ(choices[0].rung, Rung::kFull);
  EXPECT_GT(choices[0].epidermis_paths, 2);
  const int terms = choices[0].terms;
  const double margin_mm = choices[0].margin_mm;
  ForwardOptions strict;
  strict.tolerance = 1e-4;
  Model(bands, Conditions(64, Illumination::kWindow), strict, "exact")
      .Render(FreckledSkin(64, 2), {}, &choices);
  EXPECT_GT(choices[0].terms, terms);
  EXPECT_GT(choices[0].margin_mm, margin_mm);
}

// A table that no scene refuses: a single pixel, one absorption only, under both lights.
TEST(BandChoice, HoldsForASinglePixel) {
  const Band bands[] = {{450.0, 0.0}, {650.0, 10.0}};
  for (const Illumination illumination : {Illumination::kWindow, Illumination::kUniform}) {
    ImagingConditions conditions = Conditions(256, illumination);
    const auto render = Model(bands, conditions, {}, "exact").Render(ParameterMaps(1, 1, AverageSkin()));
    for (const PlaneF& plane : render) {
      EXPECT_GT(plane(0, 0), 0.0f);
      EXPECT_LT(plane(0, 0), 1.0f);
    }
  }
}

}  // namespace
}  // namespace dermap
