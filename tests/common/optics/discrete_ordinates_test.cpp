// SPDX-License-Identifier: Apache-2.0
// Flux matrices by the laws that they obey and by published values; their judges are in tests/reference.
#include "common/optics/discrete_ordinates.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "tests/reference/h_function.h"

namespace dermap {
namespace {

// Source: the rules' definition: weights sum to 1 and int mu dmu = 1/2 in every medium; Snell's law maps the
// nodes.
TEST(AngularGrid, IntegratesInEveryMedium) {
  const std::array indices{1.0, 1.4, 1.38, 1.4, 1.0};
  const AngularGrid grid = MakeAngularGrid(indices);
  for (int medium = 0; medium < 5; ++medium) {
    EXPECT_NEAR(grid.weight[medium].sum(), 1.0, 1e-6) << medium;
    EXPECT_NEAR(grid.weight[medium].dot(grid.mu[medium]), 0.5, 1e-12) << medium;
    EXPECT_EQ(grid.mu[medium](0), 1.0);
    for (int i = 0; i < std::min(grid.Size(0), grid.Size(medium)); ++i) {
      EXPECT_NEAR(indices[medium] * std::sqrt(1.0 - std::pow(grid.mu[medium](i), 2)),
                  std::sqrt(1.0 - std::pow(grid.mu[0](i), 2)), 1e-12);
    }
  }
}

// Source: Chandrasekhar's H function, from its own equation (h_function.h).
TEST(PlaneLayer, HalfSpaceIsChandrasekhars) {
  const AngularGrid grid = MakeAngularGrid(std::array{1.0}, 20);
  for (const double albedo : {0.3, 0.9, 0.999}) {
    const LightOperators half_space = SolvePlaneLayer(grid, 0, {.mu_a = 1.0 - albedo, .mu_s = albedo});
    for (const int node : {0, 7, 14}) {
      const double judge = 1.0 - reference::HFunction(grid.mu[0](node), albedo) * std::sqrt(1.0 - albedo);
      EXPECT_NEAR(half_space.r_down.col(node).sum(), judge, 1e-5) << albedo << ' ' << node;
    }
  }
}

// van de Hulst, "Multiple Light Scattering" (1980), table 35, as quoted by Wang, Jacques, Zheng 1995,
// table 1.
TEST(PlaneLayer, SlabIsVanDeHulsts) {
  const AngularGrid grid = MakeAngularGrid(std::array{1.0}, 16);
  const LightOperators slab =
      SolvePlaneLayer(grid, 0, {.mu_a = 0.2, .mu_s = 1.8, .anisotropy = 0.75, .thickness_mm = 1.0});
  EXPECT_NEAR(slab.r_down.col(0).sum(), 0.09739, 2e-5);
  EXPECT_NEAR(slab.t_down.col(0).sum(), 0.66096, 2e-5);
}

// Without absorption no light is lost, whatever it came from; source: conservation of energy.
TEST(PlaneLayer, LosesNothingWithoutAbsorption) {
  const AngularGrid grid = MakeAngularGrid(std::array{1.0, 1.4, 1.38});
  for (const double g : {0.0, 0.8, 0.95}) {
    for (const double thickness_mm : {1e-3, 0.25, 10.0}) {
      const LightOperators slab = SolvePlaneLayer(
          grid, 1, {.mu_a = 0.0, .mu_s = 6.0 / (1.0 - g), .anisotropy = g, .thickness_mm = thickness_mm});
      const LightOperators whole = Add(Add(SolveFace(grid, 0, 1), slab), SolveFace(grid, 1, 2));
      for (int node = 0; node < grid.Size(0); ++node) {
        EXPECT_NEAR(whole.r_down.col(node).sum() + whole.t_down.col(node).sum(), 1.0, 1e-5)
            << g << ' ' << node;
      }
    }
  }
}

// Two half slabs are a whole one; source: the definition of adding.
TEST(PlaneLayer, TwoHalvesAreOneWhole) {
  const AngularGrid grid = MakeAngularGrid(std::array{1.0, 1.4});
  PlaneLayer layer{.mu_a = 0.7, .mu_s = 20.0, .anisotropy = 0.8, .thickness_mm = 0.3};
  const LightOperators whole = SolvePlaneLayer(grid, 1, layer);
  layer.thickness_mm = 0.15;
  const LightOperators half = SolvePlaneLayer(grid, 1, layer);
  const LightOperators sum = Add(half, half);
  EXPECT_LT((sum.r_down - whole.r_down).cwiseAbs().maxCoeff(), 1e-10);
  EXPECT_LT((sum.t_down - whole.t_down).cwiseAbs().maxCoeff(), 1e-10);
}

// The absorber dims what crosses, not what the face mirrors; source: DESIGN section 5.
TEST(Face, AbsorberActsOnWhatCrosses) {
  const AngularGrid grid = MakeAngularGrid(std::array{1.4, 1.38});
  const LightOperators clear = SolveFace(grid, 0, 1), dark = SolveFace(grid, 0, 1, 0.5);
  EXPECT_EQ(clear.r_down, dark.r_down);
  EXPECT_LT((dark.t_up - std::exp(-0.5) * clear.t_up).cwiseAbs().maxCoeff(), 1e-15);
}

}  // namespace
}  // namespace dermap
