// SPDX-License-Identifier: Apache-2.0
// The gel's correction against adding-doubling, for which gel is one clear layer more. Expected: the quotient
// of the judge's own reflectance factors, bare skin over skin under gel, direction by direction.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "calibrate/corrections.h"
#include "tests/reference/adding_doubling.h"

namespace dermap::reference {
namespace {

constexpr double kSkin = 1.4, kGel = 1.34;

LayerStack Skin(double mu_a, bool gel) {
  LayerStack stack{1.0, {{.mu_a = mu_a, .mu_s = 6.0, .n = kSkin}}, kSkin};
  // The judge knows no layer without any extinction.
  if (gel)
    stack.layers.insert(stack.layers.begin(), {.thickness_mm = 1.0, .mu_a = 1e-7, .mu_s = 0.0, .n = kGel});
  return stack;
}

double Degrees(double cosine) {
  return std::acos(cosine) * 180.0 / std::numbers::pi;
}

// The judge's directions nearest to 0, 30 and 45 degrees, which both stacks share.
std::array<int, 3> Directions(const AngularNodes& nodes) {
  std::array<int, 3> nearest{nodes.normal, 0, 0};
  for (int i = 0; i < nodes.count[0]; ++i) {
    const auto off = [&](int node, double degrees) { return std::abs(Degrees(nodes.mu[0][node]) - degrees); };
    if (off(i, 30.0) < off(nearest[1], 30.0)) nearest[1] = i;
    if (off(i, 45.0) < off(nearest[2], 45.0)) nearest[2] = i;
  }
  return nearest;
}

// Pi times the radiance, as a share of the light that falls.
double ReflectanceFactor(const Operators& whole, const AngularNodes& nodes, int light, int view) {
  return whole.r_down(view, light) / (2.0 * nodes.mu[0][view] * nodes.weight[0][view]);
}

TEST(GelFactor, IsWhatTheJudgeSaysOfAClearLayer) {
  for (const double mu_a : {0.02, 0.3, 3.0}) {
    const AddingDoubling bare(Skin(mu_a, false)), gel(Skin(mu_a, true));
    const Operators of_bare = bare.Whole(), of_gel = gel.Whole();
    const auto directions = Directions(bare.nodes());
    for (const int light : directions) {
      for (const int view : directions) {
        if (light == view) continue;  // the mirror's direction
        ASSERT_NEAR(bare.nodes().mu[0][view], gel.nodes().mu[0][view], 1e-12);
        const double seen = ReflectanceFactor(of_gel, gel.nodes(), light, view);
        const double expected = ReflectanceFactor(of_bare, bare.nodes(), light, view) / seen;
        const RigAngles angles{Degrees(bare.nodes().mu[0][light]), Degrees(bare.nodes().mu[0][view])};
        const Known found = GelFactor({kGel, 0.0}, kSkin, angles, seen);
        EXPECT_NEAR(found.value, expected, 0.0003)
            << "R " << seen << ", light at " << angles.light_deg << ", camera at " << angles.view_deg;
        EXPECT_LT(std::abs(found.value - expected), found.sigma + 1e-5) << "R " << seen;
      }
    }
  }
}

}  // namespace
}  // namespace dermap::reference
