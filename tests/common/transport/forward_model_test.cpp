// SPDX-License-Identifier: Apache-2.0
// The forward model as a whole: closed forms, conservation, symmetry, bands with a width, threads.
#include "common/transport/forward_model.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "common/core/error.h"
#include "common/core/parallel.h"
#include "tests/common/transport/scenes.h"

namespace dermap {
namespace {

constexpr Engine kEngines[] = {Engine::kCascade, Engine::kPyramid, Engine::kLowRank};
const Band kBands[] = {{450.0, 0.0}, {560.0, 0.0}, {650.0, 0.0}};

// Uniform skin under wide light has no lateral transport to see: the closed form of the tables, from light to
// dark, within 1e-3 (what is found is 1e-5). All engines, both kinds of profiles.
TEST(ForwardModel, IsTheClosedFormForUniformSkinUnderWideLight) {
  const ParameterVector skins[] = {
      {0.01, 0.62, 0.002, 0.0, 0.01}, AverageSkin(), {0.4, 0.3, 0.04, 0.05, 0.1}};
  for (const char* source : {"multipole", "exact"}) {
    for (const Engine engine : kEngines) {
      ForwardOptions options;
      options.engine = engine;
      const ForwardModel model = Model(kBands, Conditions(48, Illumination::kUniform), options, source);
      for (const ParameterVector& skin : skins) {
        const std::vector<PlaneF> render = model.Render(ParameterMaps(48, 48, skin));
        for (int band = 0; band < 3; ++band) {
          const double expected = model.LocalReflectance(band, skin, 0.0175);
          for (const auto& [x, y] : {std::pair(0, 0), std::pair(24, 24), std::pair(47, 10)}) {
            EXPECT_NEAR(render[band](x, y), expected, 1e-3 * expected) << source << ' ' << EngineName(engine);
          }
        }
      }
    }
  }
}

// All that falls on a spot far from any border comes back somewhere, as much as the closed form says: lateral
// transport moves light and loses none.
TEST(ForwardModel, MovesLightAndLosesNone) {
  const int size = 192;
  PlaneF light(size, size, 0.0f);
  double fallen = 0.0;
  for (int y = 80; y < 112; ++y) {
    for (int x = 80; x < 112; ++x)
      light(x, y) = 0.5f + 0.01f * static_cast<float>(x - y), fallen += light(x, y);
  }
  for (const Engine engine : kEngines) {
    ForwardOptions options;
    options.engine = engine;
    options.margin_mm = 6.0;
    ImagingConditions conditions = Conditions(size, Illumination::kWindow);
    conditions.pixel_size_mm = 0.1;
    const ForwardModel model = Model(kBands, conditions, options);
    for (int band = 0; band < 3; ++band) {
      const PlaneF render = model.RenderBand(band, ParameterMaps(size, size, AverageSkin()), &light);
      double returned = 0.0;
      for (const float value : render.values()) returned += value;
      EXPECT_NEAR(returned / fallen / model.LocalReflectance(band, AverageSkin(), 0.0175), 1.0, 1e-3)
          << EngineName(engine) << ", band " << band;
    }
  }
}

// The model is linear in the light: what two lights return together is the sum of what each returns.
TEST(ForwardModel, IsLinearInTheLight) {
  const ForwardModel model = Model(kBands, Conditions(64, Illumination::kWindow));
  const ParameterMaps maps = FreckledSkin(64, 1);
  const PlaneF a = Noise(64, 64, 1, 0.0f, 1.0f), b = Noise(64, 64, 2, 0.0f, 1.0f);
  PlaneF both(64, 64);
  for (std::size_t i = 0; i < both.size(); ++i) both.data()[i] = 2.0f * a.data()[i] + 3.0f * b.data()[i];
  const PlaneF render_a = model.RenderBand(1, maps, &a), render_b = model.RenderBand(1, maps, &b);
  PlaneF sum(64, 64);
  for (std::size_t i = 0; i < sum.size(); ++i)
    sum.data()[i] = 2.0f * render_a.data()[i] + 3.0f * render_b.data()[i];
  EXPECT_LT(Compare(model.RenderBand(1, maps, &both), sum).relative_max, 1e-5);
  EXPECT_LT(
      Compare(model.RenderBand(1, maps), model.RenderBand(1, maps, std::array{PlaneF(64, 64, 1.0f)}.data()))
          .relative_max,
      1e-7);
}

ParameterMaps Transposed(const ParameterMaps& maps) {
  ParameterMaps out(maps.height(), maps.width(), AverageSkin());
  for (int p = 0; p < kParameterCount; ++p) {
    for (int y = 0; y < maps.height(); ++y) {
      for (int x = 0; x < maps.width(); ++x) out.planes[p](y, x) = maps.planes[p](x, y);
    }
  }
  return out;
}

// Rows and columns are alike to skin: the transposed scene renders as the transposed render.
TEST(ForwardModel, TreatsRowsAndColumnsAlike) {
  for (const Engine engine : kEngines) {
    ForwardOptions options;
    options.engine = engine;
    const ForwardModel model = Model(kBands, Conditions(64, Illumination::kWindow), options);
    const ParameterMaps maps = FreckledSkin(64, 3);
    const PlaneF render = model.RenderBand(2, maps), other = model.RenderBand(2, Transposed(maps));
    PlaneF back(64, 64);
    for (int y = 0; y < 64; ++y) {
      for (int x = 0; x < 64; ++x) back(x, y) = other(y, x);
    }
    EXPECT_LT(Compare(back, render).relative_max, 1e-5) << EngineName(engine);
  }
}

// Skin knows no origin: moved light returns as the moved image. Not by a multiple of the pyramid's coarse
// pixels, whose grid must not show.
TEST(ForwardModel, KnowsNoOrigin) {
  const int size = 128, shift = 5;
  PlaneF here(size, size, 0.0f), there(size, size, 0.0f);
  for (int y = 50; y < 60; ++y) {
    for (int x = 50; x < 60; ++x) here(x, y) = there(x + shift, y) = 1.0f;
  }
  const ParameterMaps maps(size, size, AverageSkin());
  for (const Engine engine : kEngines) {
    ForwardOptions options;
    options.engine = engine;
    options.margin_mm = 3.0;
    ImagingConditions conditions;
    conditions.pixel_size_mm = 0.05;
    const ForwardModel model = Model(kBands, conditions, options);
    const PlaneF a = model.RenderBand(2, maps, &here), b = model.RenderBand(2, maps, &there);
    for (int y = 30; y < 80; ++y) {
      for (int x = 30; x < 80; ++x)
        EXPECT_NEAR(a(x, y), b(x + shift, y), 3e-4 * a(55, 55)) << EngineName(engine);
    }
  }
}

// Renders must not depend on how many threads shared the work: the same bits.
TEST(ForwardModel, GivesTheSameBitsForAnyNumberOfThreads) {
  const ParameterMaps maps = FreckledSkin(64, 4);
  std::vector<std::vector<PlaneF>> renders;
  for (const int threads : {1, 2, 5}) {
    const ThreadLimit limit(threads);
    const ForwardModel model = Model(kBands, Conditions(64, Illumination::kWindow));
    renders.push_back(model.Render(maps));
    renders.push_back(model.Render(maps));  // with memory that has been used before
  }
  for (std::size_t i = 1; i < renders.size(); ++i) {
    for (int band = 0; band < 3; ++band) {
      for (std::size_t j = 0; j < maps.planes[0].size(); ++j) {
        ASSERT_EQ(renders[i][band].data()[j], renders[0][band].data()[j]);
      }
    }
  }
}

// A renderer keeps memory from patch to patch: another shape in between must not show.
TEST(ForwardModel, RendersPatchesOfAnyShape) {
  const ForwardModel model = Model(kBands, Conditions(64, Illumination::kWindow));
  const ParameterMaps maps = FreckledSkin(40, 5);
  const PlaneF first = model.RenderBand(0, maps);
  EXPECT_TRUE(model.RenderBand(0, ParameterMaps(17, 90, AverageSkin())).SameShape(17, 90));
  EXPECT_TRUE(model.RenderBand(0, ParameterMaps(1, 1, AverageSkin())).SameShape(1, 1));
  EXPECT_EQ(Compare(model.RenderBand(0, maps), first).relative_max, 0.0);
}

// Central differences of the closed form itself.
TEST(ForwardModel, LocalGradientIsTheSlope) {
  const Band bands[] = {{470.0, 10.0}, {580.0, 10.0}};
  for (const char* source : {"multipole", "exact"}) {
    const ForwardModel model = Model(bands, Conditions(32, Illumination::kWindow), {}, source);
    for (const ParameterVector& p : {AverageSkin(), ParameterVector{0.2, 0.4, 0.02, 0.03, 0.08}}) {
      for (int band = 0; band < 2; ++band) {
        ParameterVector gradient;
        const double reflectance = model.LocalReflectance(band, p, 0.05, gradient);
        EXPECT_NEAR(reflectance, model.LocalReflectance(band, p, 0.05), 1e-9);
        for (int k = 0; k < kParameterCount; ++k) {
          // Steps far smaller than a step of the table, whose interpolation has kinks.
          const double step = 1e-5 * (kParameters[k].upper - kParameters[k].lower);
          ParameterVector up = p, down = p;
          up[k] += step;
          down[k] -= step;
          const double slope =
              (model.LocalReflectance(band, up, 0.05) - model.LocalReflectance(band, down, 0.05)) /
              (2.0 * step);
          EXPECT_NEAR(gradient[k], slope, 0.02 * std::abs(slope) + 1e-4)
              << kParameters[k].name << ' ' << source;
        }
      }
    }
  }
}

// Fresnel's equations and Snell's law, by Simpson's rule, written out here: for n = 1.4 F(30 degrees) =
// 0.02905, and of diffuse light 7.7 % is reflected.
TEST(ForwardModel, ExitAngleFactorIsFresnels) {
  const double n = 1.4;
  const auto reflected = [&](double mu) {
    const double sine = std::sqrt(1.0 - mu * mu) / n, inside = std::sqrt(1.0 - sine * sine);
    const double s = (mu - n * inside) / (mu + n * inside), p = (n * mu - inside) / (n * mu + inside);
    return 0.5 * (s * s + p * p);
  };
  double diffuse = 0.0;
  const int steps = 2000;
  for (int i = 0; i <= steps; ++i) {
    const double mu = static_cast<double>(i) / steps;
    diffuse += (i == 0 || i == steps ? 1.0
                : i % 2              ? 4.0
                                     : 2.0) /
               (3.0 * steps) * 2.0 * mu * (1.0 - reflected(mu));
  }
  const double at_30 = 1.0 - reflected(std::cos(std::numbers::pi / 6.0));
  EXPECT_NEAR(at_30, 1.0 - 0.02905, 1e-5);
  EXPECT_NEAR(ExitAngleFactor(Geometry::kFactor0_30, 1.0, n), at_30 / diffuse, 1e-5);
  EXPECT_EQ(ExitAngleFactor(Geometry::kHemispherical, 1.0, n), 1.0);
  ImagingConditions conditions = Conditions(32, Illumination::kUniform);
  const double hemispherical =
      Model(kBands, conditions).RenderBand(1, ParameterMaps(32, 32, AverageSkin()))(3, 3);
  conditions.geometry = Geometry::kFactor0_30;
  const ForwardModel tilted = Model(kBands, conditions);
  EXPECT_NEAR(tilted.RenderBand(1, ParameterMaps(32, 32, AverageSkin()))(3, 3),
              hemispherical * at_30 / diffuse, 1e-5);
  EXPECT_NEAR(tilted.LocalReflectance(1, AverageSkin(), 0.0175), hemispherical * at_30 / diffuse, 1e-5);
}

// What progress.h promises a caller: fractions that rise to 1.
TEST(ForwardModel, ReportsProgressOfItsTables) {
  std::vector<double> fractions;
  const ForwardModel model(TestChromophores(), TestSource(), TissueConfig{}, kBands,
                           Conditions(32, Illumination::kWindow), {},
                           [&](double f) { fractions.push_back(f); });
  ASSERT_EQ(fractions.size(), 3u);
  EXPECT_TRUE(std::is_sorted(fractions.begin(), fractions.end()));
  EXPECT_EQ(fractions.back(), 1.0);
}

// Names as on the command line.
TEST(Engine, IsFoundByName) {
  for (const Engine engine : kEngines) EXPECT_EQ(EngineFromName(EngineName(engine)), engine);
  EXPECT_THROW(EngineFromName("gpu"), InputError);
}

}  // namespace
}  // namespace dermap
