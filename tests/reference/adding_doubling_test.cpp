// SPDX-License-Identifier: Apache-2.0
// The adding-doubling judge against published values and laws of conservation.
#include "tests/reference/adding_doubling.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/reference/h_function.h"
#include "tests/reference/quadrature.h"

namespace dermap::reference {
namespace {

// Source: the rule's definition, exact for x^0 .. x^4 with three nodes of which one is 1.
TEST(Quadrature, RadauIsExactForItsDegree) {
  const Rule rule = GaussRadauRight(3, -1.0, 1.0);
  EXPECT_DOUBLE_EQ(rule.nodes.back(), 1.0);
  for (int power = 0; power <= 4; ++power) {
    double sum = 0.0;
    for (int i = 0; i < 3; ++i) sum += rule.weights[i] * std::pow(rule.nodes[i], power);
    EXPECT_NEAR(sum, power % 2 == 0 ? 2.0 / (power + 1) : 0.0, 1e-13) << power;
  }
}

// van de Hulst's slab, "Multiple Light Scattering" (1980), table 35, as quoted by Wang, Jacques, Zheng 1995,
// table 1: n 1, albedo 0.9, optical thickness 2, g 0.75: Rd 0.09739, T 0.66096.
TEST(AddingDoubling, MatchesVanDeHulstsSlab) {
  const LayerStack slab{1.0, {{.thickness_mm = 1.0, .mu_a = 0.2, .mu_s = 1.8, .g = 0.75, .n = 1.0}}, 1.0};
  const Totals totals = NormalIncidenceTotals(slab, 20);
  EXPECT_NEAR(totals.reflectance, 0.09739, 1e-5);
  EXPECT_NEAR(totals.transmittance, 0.66096, 1e-5);
  EXPECT_NEAR(totals.ballistic, std::exp(-2.0), 1e-12);
}

// Giovanelli 1955, as quoted by Wang, Jacques, Zheng 1995: half-space, n 1.5, albedo 0.9, isotropic: 0.2600
// with the specular 0.04 in it.
TEST(AddingDoubling, MatchesGiovanellisHalfSpace) {
  const LayerStack half_space{1.0, {{.mu_a = 0.1, .mu_s = 0.9, .n = 1.5}}, 1.5};
  const Totals totals = NormalIncidenceTotals(half_space);
  EXPECT_NEAR(totals.specular, 0.04, 1e-12);
  EXPECT_NEAR(totals.reflectance + totals.specular, 0.2600, 1e-4);
}

// Without absorption nothing is lost; source: conservation of energy.
TEST(AddingDoubling, ConservesEnergyThroughLayersOfDifferentIndex) {
  const LayerStack stack{1.0,
                         {{.thickness_mm = 0.25, .mu_s = 6.0, .n = 1.4},
                          {.thickness_mm = 0.8, .mu_s = 15.0, .g = 0.8, .n = 1.38},
                          {.thickness_mm = 0.25, .mu_s = 6.0, .n = 1.4}},
                         1.0};
  const Totals totals = NormalIncidenceTotals(stack);
  EXPECT_NEAR(totals.reflectance + totals.specular + totals.transmittance, 1.0, 1e-8);
}

// A conservative half-space returns everything that enters it; source: conservation of energy.
TEST(AddingDoubling, HalfSpaceWithoutAbsorptionReturnsEverything) {
  const LayerStack half_space{1.0, {{.mu_a = 1e-9, .mu_s = 3.0, .n = 1.38}}, 1.38};
  const Totals totals = NormalIncidenceTotals(half_space);
  EXPECT_NEAR(totals.reflectance + totals.specular, 1.0, 5e-4);
}

// Source: Chandrasekhar's H function, from its own equation (h_function.h).
TEST(AddingDoubling, MatchesChandrasekharsHFunction) {
  for (const double albedo : {0.3, 0.7, 0.99}) {
    const LayerStack half_space{1.0, {{.mu_a = 1.0 - albedo, .mu_s = albedo, .n = 1.0}}, 1.0};
    EXPECT_NEAR(NormalIncidenceTotals(half_space).reflectance,
                1.0 - HFunction(1.0, albedo) * std::sqrt(1.0 - albedo), 2e-5)
        << albedo;
  }
}

// Diffuse transmittance is the same from both sides of any stack between equal media; source: reciprocity.
TEST(AddingDoubling, TransmitsDiffuseLightEquallyBothWays) {
  const LayerStack stack{1.0,
                         {{.thickness_mm = 0.25, .mu_a = 2.0, .mu_s = 6.0, .n = 1.4, .absorber_below = 0.4},
                          {.thickness_mm = 0.8, .mu_a = 0.1, .mu_s = 3.0, .n = 1.38}},
                         1.0};
  const AddingDoubling judge(stack);
  const Operators whole = judge.Whole();
  const Eigen::VectorXd above = judge.LambertianFlux(0, 3, false), below = judge.LambertianFlux(3, 0, false);
  EXPECT_NEAR((whole.t_down * above).sum(), (whole.t_up * below).sum(), 1e-10);
}

// The absorber acts on what crosses, not on what the face reflects: with an opaque one only the upper layer
// is seen; source: the definition in the design.
TEST(AddingDoubling, AbsorberActsOnWhatCrosses) {
  LayerStack stack{1.0,
                   {{.thickness_mm = 0.25, .mu_a = 0.5, .mu_s = 6.0, .n = 1.4, .absorber_below = 50.0},
                    {.mu_a = 0.2, .mu_s = 3.0, .n = 1.38}},
                   1.38};
  const double covered = NormalIncidenceTotals(stack).reflectance;
  LayerStack alone = stack;
  alone.layers.pop_back();
  EXPECT_NEAR(covered, NormalIncidenceTotals(alone).reflectance, 1e-12);
  stack.layers[0].absorber_below = 0.0;
  EXPECT_GT(NormalIncidenceTotals(stack).reflectance, covered + 0.03);
}

}  // namespace
}  // namespace dermap::reference
