// SPDX-License-Identifier: Apache-2.0
// Adding layers: against light followed step by step, and by the laws that any stack obeys.
#include "common/optics/layers.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "common/optics/multipole.h"

namespace dermap {
namespace {

LayerTransforms RandomLayer(std::mt19937& random) {
  std::uniform_real_distribution<double> share(0.05, 0.45);
  return {{share(random)}, {share(random)}, {share(random)}, {share(random)}};
}

// Follows light through a stack of any layers, passage by passage, until none is left: no adding formula, no
// series. `downward[i]` is light falling on layer i from above, `upward[i]` on it from below.
struct Followed {
  double reflected = 0.0, transmitted = 0.0;
};
Followed FollowLight(const std::vector<LayerTransforms>& layers, const std::vector<double>& absorbance,
                     bool from_above) {
  const int count = static_cast<int>(layers.size());
  std::vector<double> downward(count, 0.0), upward(count, 0.0);
  (from_above ? downward.front() : upward.back()) = 1.0;
  double out_above = 0.0, out_below = 0.0;
  for (int passage = 0; passage < 2000; ++passage) {
    std::vector<double> next_downward(count, 0.0), next_upward(count, 0.0);
    for (int i = 0; i < count; ++i) {
      const double up = downward[i] * layers[i].r_forward[0] + upward[i] * layers[i].t_backward[0];
      const double down = downward[i] * layers[i].t_forward[0] + upward[i] * layers[i].r_backward[0];
      (i == 0 ? out_above : next_upward[i - 1]) += i == 0 ? up : up * std::exp(-absorbance[i - 1]);
      (i == count - 1 ? out_below : next_downward[i + 1]) +=
          i == count - 1 ? down : down * std::exp(-absorbance[i]);
    }
    downward = next_downward;
    upward = next_upward;
  }
  return from_above ? Followed{out_above, out_below} : Followed{out_below, out_above};
}

void ExpectFollowed(const std::vector<LayerTransforms>& layers, const std::vector<double>& absorbance) {
  const auto stack = CombineLayers(layers, absorbance);
  const auto forward = FollowLight(layers, absorbance, true);
  const auto backward = FollowLight(layers, absorbance, false);
  EXPECT_NEAR(stack.r_forward[0], forward.reflected, 1e-12);
  EXPECT_NEAR(stack.t_forward[0], forward.transmitted, 1e-12);
  EXPECT_NEAR(stack.r_backward[0], backward.reflected, 1e-12);
  EXPECT_NEAR(stack.t_backward[0], backward.transmitted, 1e-12);
}

// Light followed through random layers, two, three and five of them, with absorbers between.
TEST(CombineLayers, MatchesLightFollowedStepByStep) {
  std::mt19937 random(20080461);
  for (const int count : {1, 2, 3, 5}) {
    std::vector<LayerTransforms> layers;
    std::vector<double> absorbance;
    for (int i = 0; i < count; ++i) layers.push_back(RandomLayer(random));
    for (int i = 0; i + 1 < count; ++i) absorbance.push_back(0.3 * i + 0.0175);
    ExpectFollowed(layers, absorbance);
  }
}

// Adding is associative: the upper two first, or the lower two.
TEST(CombineLayers, DoesNotDependOnTheOrderOfAdding) {
  std::mt19937 random(7);
  const auto a = RandomLayer(random), b = RandomLayer(random), c = RandomLayer(random);
  const auto left = CombineLayers(CombineLayers(a, b, 0.1), c, 0.2);
  const auto right = CombineLayers(a, CombineLayers(b, c, 0.2), 0.1);
  EXPECT_NEAR(left.r_forward[0], right.r_forward[0], 1e-15);
  EXPECT_NEAR(left.t_forward[0], right.t_forward[0], 1e-15);
  EXPECT_NEAR(left.r_backward[0], right.r_backward[0], 1e-15);
  EXPECT_NEAR(left.t_backward[0], right.t_backward[0], 1e-15);
}

LayerTransforms Slab(double mu_a, double mu_s, double thickness_mm, double a_top, double a_bottom, double k) {
  const MultipoleSlab down({mu_a, mu_s, 1.4}, thickness_mm, a_top, a_bottom);
  const MultipoleSlab up({mu_a, mu_s, 1.4}, thickness_mm, a_bottom, a_top);
  return {{down.Reflectance(k)}, {down.Transmittance(k)}, {up.Reflectance(k)}, {up.Transmittance(k)}};
}

// No absorber, no loss: R + T of the stack is 1 in both directions (three layers, as an ear has [D08 5.3]).
TEST(CombineLayers, ConservesEnergyWithoutAbsorption) {
  const std::vector<LayerTransforms> ear{Slab(0.0, 6.0, 0.25, 3.2, 1.07, 0.0),
                                         Slab(0.0, 3.0, 1.0, 1.0, 1.0, 0.0),
                                         Slab(0.0, 6.0, 0.25, 1.07, 3.2, 0.0)};
  const auto stack = CombineLayers(ear, std::vector<double>{0.0, 0.0});
  EXPECT_NEAR(stack.r_forward[0] + stack.t_forward[0], 1.0, 1e-13);
  EXPECT_NEAR(stack.r_backward[0] + stack.t_backward[0], 1.0, 1e-13);
  const auto inked = CombineLayers(ear, std::vector<double>{0.5, 0.0});
  EXPECT_LT(inked.r_forward[0] + inked.t_forward[0], 0.99);
}

// Helmholtz: layers that each transmit alike in both directions form a stack that does, at every frequency
// and whatever they reflect; and a stack that is its own mirror image reflects alike from both sides.
TEST(CombineLayers, IsReciprocal) {
  for (const double k : {0.0, 1.0, 20.0}) {
    const auto a = Slab(0.2, 6.0, 0.25, 1.3, 1.3, k), b = Slab(2.0, 9.0, 0.5, 1.0, 1.0, k);
    const auto stack = CombineLayers(a, b, 0.3);
    EXPECT_NEAR(stack.t_forward[0], stack.t_backward[0], 1e-15);
    EXPECT_GT(std::abs(stack.r_forward[0] - stack.r_backward[0]), 1e-3 * stack.r_forward[0]);
    const auto mirrored = CombineLayers(std::vector<LayerTransforms>{a, b, a}, std::vector<double>{0.3, 0.3});
    EXPECT_NEAR(mirrored.r_forward[0], mirrored.r_backward[0], 1e-15);
  }
}

EpidermisTransforms MadeUpEpidermis(double r_forward, double t_forward, double r_backward, double t_backward,
                                    double t_ballistic) {
  EpidermisTransforms epidermis;
  epidermis.r_forward = {r_forward};
  epidermis.t_forward = {t_forward};
  epidermis.r_backward = {r_backward};
  epidermis.t_backward = {t_backward};
  epidermis.t_ballistic = t_ballistic;
  return epidermis;
}

// [D08 eq. 7] term by term, mended: T1+ A (R2 A R1- A)^n R2 A T1-; forty terms of the series and its closed
// form.
TEST(TwoLayerReflectance, IsTheSeriesOfEquation7) {
  const double r1 = 0.1, t1 = 0.5, r1_back = 0.6, t1_back = 0.35, r2 = 0.7, p = 0.2, a = std::exp(-p);
  const auto epidermis = MadeUpEpidermis(r1, t1, r1_back, t1_back, 0.0);
  const DermisTransforms dermis{{r2}, {0.123}};  // without ballistic light its response must not matter
  double sum = r1, upward = t1 * a * r2 * a;
  for (int n = 0; n < 40; ++n) {
    sum += upward * t1_back;
    upward *= r1_back * a * r2 * a;
  }
  EXPECT_NEAR(TwoLayerReflectance(epidermis, dermis, p)[0], sum, 1e-14);
}

// Ballistic light meets the dermis's response to normal light once and is diffuse from then on: by hand,
// 0.1 + (0.2*0.8 + 0.3*0.5) * 0.4 / (1 - 0.6*0.5) = 0.1 + 0.124/0.7.
TEST(TwoLayerReflectance, KeepsTheBallisticPartApart) {
  const auto epidermis = MadeUpEpidermis(0.1, 0.3, 0.6, 0.4, 0.2);
  const DermisTransforms dermis{{0.5}, {0.8}};
  EXPECT_NEAR(TwoLayerReflectance(epidermis, dermis, 0.0)[0], 0.1 + 0.124 / 0.7, 1e-15);
  EXPECT_EQ(AsLayer(epidermis).t_forward[0], 0.5);
}

// The two ways to the same number, for a source without ballistic part.
TEST(TwoLayerReflectance, AgreesWithCombineLayers) {
  const auto source = MakeProfileSource("multipole");
  const double k[] = {0.0, 0.5, 5.0};
  const auto epidermis = source->Epidermis({.layer = {1.0, 6.0, 1.4}}, k);
  const auto dermis = source->Dermis({.layer = {0.3, 3.0, 1.38}}, k);
  const auto direct = TwoLayerReflectance(epidermis, dermis, 0.0175);
  const auto stack = CombineLayers(AsLayer(epidermis), AsLayer(dermis), 0.0175);
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(direct[i], stack.r_forward[i], 1e-15);
}

}  // namespace
}  // namespace dermap
