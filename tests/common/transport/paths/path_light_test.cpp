// SPDX-License-Identifier: Apache-2.0
// The low-rank engine against the plain cascade, and what the reciprocal coupling is defined by.
#include "common/transport/paths/path_light.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/common/transport/scenes.h"

namespace dermap {
namespace {

PlaneF Inner(const PlaneF& plane, int inset) {
  PlaneF inner(plane.width() - 2 * inset, plane.height() - 2 * inset);
  for (int y = 0; y < inner.height(); ++y)
    std::copy_n(plane.Row(y + inset) + inset, inner.width(), inner.Row(y));
  return inner;
}

const Band kBands[] = {{450.0, 0.0}, {560.0, 0.0}, {650.0, 0.0}};

// Source: the cascade, the paper's sum of 18 blurs, with the same (gather) coupling: what differs is few path
// lengths for 18 Gaussians, ever coarser grids, cosine transforms for blurs. Of the multipole, whose profiles
// sums of Gaussians fit. Where light goes on beyond the border, the cascade repeats the border's pixels and
// the other mirrors the patch: compared inside.
TEST(PathLight, IsTheCascadeUnderGatherCoupling) {
  const ParameterMaps maps = FreckledSkin(96, 3);
  for (const Illumination illumination : {Illumination::kUniform, Illumination::kWindow}) {
    ForwardOptions slow, fast;
    slow.engine = Engine::kCascade;
    fast.engine = Engine::kLowRank;
    fast.coupling = Coupling::kGather;
    fast.tolerance = 2e-4;
    slow.margin_mm = fast.margin_mm = 3.0;
    const ForwardModel cascade = Model(kBands, Conditions(96, illumination), slow);
    const ForwardModel lowrank = Model(kBands, Conditions(96, illumination), fast);
    const auto expected = cascade.Render(maps), found = lowrank.Render(maps);
    for (int band = 0; band < 3; ++band) {
      const int inset = illumination == Illumination::kUniform ? 24 : 0;
      const Difference difference = Compare(Inner(found[band], inset), Inner(expected[band], inset));
      EXPECT_LT(difference.relative_rms, 3e-3) << band;
      EXPECT_LT(difference.relative_max, 2e-2) << band;
    }
  }
}

// Source: couplings differ only where skin does.
TEST(PathLight, CouplingsAgreeOnUniformSkin) {
  ForwardOptions gather;
  gather.coupling = Coupling::kGather;
  const auto conditions = Conditions(64, Illumination::kWindow);
  const ParameterMaps maps(64, 64, AverageSkin());
  const auto a = Model(kBands, conditions).Render(maps), b = Model(kBands, conditions, gather).Render(maps);
  for (int band = 0; band < 3; ++band) EXPECT_LT(Compare(a[band], b[band]).relative_max, 1e-3);
}

// Source: the definition of the reciprocal coupling. Under light that falls evenly, what leaves bright skin
// beside dark skin is less than what leaves it far away, and dark skin beside bright returns more; by gather
// coupling, which forgets what the light met before, it is the other way round.
TEST(PathLight, LightRemembersWhereItCameFrom) {
  const int size = 128;
  ParameterMaps maps(size, size, AverageSkin());
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < size; ++x) maps[Parameter::kC_m](x, y) = x < size / 2 ? 0.05f : 0.3f;
  ForwardOptions gather;
  gather.coupling = Coupling::kGather;
  const auto conditions = Conditions(size, Illumination::kUniform);
  const auto at = [&](const ForwardModel& model, int x) { return model.RenderBand(1, maps)(x, size / 2); };
  const ForwardModel reciprocal = Model(kBands, conditions, {}, "exact");
  const ForwardModel gathering = Model(kBands, conditions, gather, "exact");
  const int edge = size / 2;
  EXPECT_LT(at(reciprocal, edge - 1), 0.8 * at(reciprocal, 8));
  EXPECT_GT(at(reciprocal, edge), 1.2 * at(reciprocal, size - 8));
  EXPECT_GT(at(gathering, edge - 1), at(reciprocal, edge - 1));
  EXPECT_LT(at(gathering, edge), at(reciprocal, edge));
}

// Source: a finer choice of every approximation: 20 times the tolerance, twice the margin.
TEST(PathLight, DefaultsAreWithinTheirTolerance) {
  ForwardOptions fine;
  fine.tolerance = 1e-5;
  fine.margin_mm = 4.0;
  const ParameterMaps maps = FreckledSkin(128, 5);
  const auto conditions = Conditions(128, Illumination::kWindow);
  const auto expected = Model(kBands, conditions, fine, "exact").Render(maps);
  const auto found = Model(kBands, conditions, {}, "exact").Render(maps);
  for (int band = 0; band < 3; ++band)
    EXPECT_LT(Compare(found[band], expected[band]).relative_rms, 1e-3) << band;
}

// Neighbouring scenes are rendered through the same path lengths: no jump where a map changes by little.
TEST(PathLight, RangesAreStableUnderSmallChanges) {
  PlaneF mu_a = Noise(32, 32, 1, 0.5f, 2.0f);
  const AbsorptionRange before = RangeOf(mu_a);
  for (float& value : mu_a.values()) value *= 1.001f;
  const AbsorptionRange after = RangeOf(mu_a);
  EXPECT_EQ(before.lowest, after.lowest);
  EXPECT_EQ(before.highest, after.highest);
  EXPECT_LT(before.lowest, 0.5);
  EXPECT_GT(before.highest, 2.0);
}

// Skins of the same range may take part to different margins: a plan is of the grid that it is asked for, or
// what reads it reads past its end.
TEST(PathPlans, AreOfTheGridTheyAreAskedFor) {
  PathPlans plans;
  const ForwardOptions options;
  const AbsorptionRange range{0.1, 0.5};
  for (const double margin_mm : {1.0, 3.0, 1.0}) {
    const PathFrames frames(64, 64, Conditions(64, Illumination::kWindow), margin_mm, options);
    const auto plan = plans.Get(TestTables(560.0, "exact"), range, range, false, frames, options);
    EXPECT_EQ(plan->r2_diffuse.planes[0].width(), frames.transforms().width) << margin_mm;
    EXPECT_EQ(plan->r2_diffuse_rest.planes[0].width(), frames.rest.width) << margin_mm;
  }
}

}  // namespace
}  // namespace dermap
