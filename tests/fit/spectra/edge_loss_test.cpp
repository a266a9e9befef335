// SPDX-License-Identifier: Apache-2.0
// Light lost beside an aperture, against geometry and against photons.
#include "fit/spectra/edge_loss.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "common/core/error.h"
#include "tests/reference/monte_carlo.h"

namespace dermap {
namespace {

// Source: two equal discs, centres one radius apart, share 2/3 - sqrt(3) / (2 pi) of their area.
TEST(DiscOverlap, IsTheLensOfTwoDiscs) {
  EXPECT_NEAR(DiscOverlap({2.0, 2.0}, 2.0), 2.0 / 3.0 - std::sqrt(3.0) / (2.0 * std::numbers::pi), 1e-12);
  EXPECT_EQ(DiscOverlap({4.0, 5.5}, 1.5), 1.0);
  EXPECT_EQ(DiscOverlap({4.0, 5.5}, 9.5), 0.0);
  EXPECT_DOUBLE_EQ(DiscOverlap({4.0, 5.5}, 3.0), DiscOverlap({5.5, 4.0}, 3.0));  // reciprocal
}

// Source: Monte Carlo of R(r) in rings, weighted with what the aperture misses, three standard errors and 4 %
// of the loss. Red light in pale skin loses some 5 %. Twice as thick an epidermis as the table's sends more
// light back itself: at most 35 % of a loss of 0.6 %.
TEST(EdgeLoss, IsWhatPhotonsLeaveBesideTheAperture) {
  const Aperture aperture{4.0, 5.5};
  const EdgeLoss loss(aperture, {}, {});
  struct Skin {
    double mu_s, mu_a_epidermis, mu_a_dermis, thickness_mm, tolerance;
  };
  for (const Skin skin : {Skin{5.0, 0.3, 0.04, 0.06, 0.04}, Skin{4.0, 2.0, 0.08, 0.06, 0.04},
                          Skin{7.0, 1.5, 0.09, 0.12, 0.35}}) {
    reference::MonteCarloScene scene;
    scene.stack = {1.0,
                   {{.thickness_mm = skin.thickness_mm,
                     .mu_a = skin.mu_a_epidermis,
                     .mu_s = skin.mu_s,
                     .n = 1.4,
                     .absorber_below = 0.0175},
                    {.mu_a = skin.mu_a_dermis, .mu_s = 0.5 * skin.mu_s, .n = 1.38}},
                   1.38};
    for (int i = 0; i <= 60; ++i) scene.radial_edges_mm.push_back(0.5 * i);
    const auto photons = reference::RunMonteCarlo(scene, {.photons = 60000, .seed = 4, .threads = 2});
    double lost = 0.0, variance = 0.0;
    for (int i = 0; i < 60; ++i) {
      const double from = scene.radial_edges_mm[i], to = scene.radial_edges_mm[i + 1];
      const double missed =
          (1.0 - DiscOverlap(aperture, 0.5 * (from + to))) * std::numbers::pi * (to * to - from * from);
      lost += missed * photons.radial_reflectance[i].value;
      variance += std::pow(missed * photons.radial_reflectance[i].standard_error, 2);
    }
    const double share = lost / photons.reflectance.value;
    const double table =
        std::exp(loss.log_loss()
                     .At({std::log(skin.mu_s), std::log(skin.mu_a_epidermis * skin.thickness_mm),
                          std::log(skin.mu_a_dermis)})
                     .value);
    EXPECT_GT(share, 0.005);
    EXPECT_NEAR(table, share, skin.tolerance * share + 3.0 * std::sqrt(variance) / photons.reflectance.value);
  }
}

// Source: the documented range.
TEST(EdgeLoss, RefusesAnApertureOfNoSize) {
  EXPECT_THROW(EdgeLoss({0.1, 5.0}, {}, {}), InputError);
  EXPECT_THROW(EdgeLoss({4.0, 80.0}, {}, {}), InputError);
}

}  // namespace
}  // namespace dermap
