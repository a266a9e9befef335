// SPDX-License-Identifier: Apache-2.0
// The solver of exact_layer.h against closed forms, symmetry, and its own limit.
#include "common/optics/exact_layer.h"

#include <gtest/gtest.h>

#include <cmath>

#include "common/optics/exact_mesh.h"
#include "common/optics/gauss_legendre.h"
#include "tests/reference/h_function.h"

namespace dermap {
namespace {

constexpr ExactResolution kFine{.free_nodes = 48,
                                .nodes_per_interval = 16,
                                .fine_nodes_per_interval = 24,
                                .azimuths_per_kappa = 3.0,
                                .max_azimuths = 60,
                                .smallest_element = 0.03,
                                .element_ratio = 2.0,
                                .largest_element = 0.8};

// Orthonormal Legendre polynomials on [0, h].
double Legendre(int i, double x, double h) {
  const double t = 2.0 * x / h - 1.0;
  const double p[] = {1.0, t, 0.5 * (3.0 * t * t - 1.0), 0.5 * t * (5.0 * t * t - 3.0)};
  return std::sqrt((2 * i + 1) / h) * p[i];
}

// Source: Gauss-Legendre quadrature of the definition, on both sides of every branch.
TEST(DepthMesh, MomentsAreTheIntegrals) {
  for (const double rate_height : {1e-3, 0.3, 0.79, 0.81, 3.0, 25.0}) {
    const double h = 0.7, rate = rate_height / h;
    const auto moments = MomentsOfExponential(rate, h);
    const auto leaning = MomentsOfExponential(std::complex<double>(rate, 0.6 * rate), h);
    const QuadratureRule rule = GaussLegendreRule(60, 0.0, h);
    for (int i = 0; i < kElementModes; ++i) {
      double sum = 0.0;
      std::complex<double> complex_sum = 0.0;
      for (std::size_t q = 0; q < rule.nodes.size(); ++q) {
        const double x = rule.nodes[q];
        sum += rule.weights[q] * Legendre(i, x, h) * std::exp(-rate * x);
        complex_sum +=
            rule.weights[q] * Legendre(i, x, h) * std::exp(-std::complex<double>(rate, 0.6 * rate) * x);
      }
      EXPECT_NEAR(moments.values[i], sum, 1e-12) << rate_height << ' ' << i;
      EXPECT_NEAR(std::abs(leaning.values[i] - complex_sum), 0.0, 1e-12) << rate_height << ' ' << i;
    }
  }
}

// Source: quadrature of the double integral, split at x = y.
TEST(DepthMesh, SelfMomentsAreTheDoubleIntegrals) {
  for (const double rate : {0.05, 0.9, 7.0}) {
    const double h = 0.7;
    const SelfMoments self = SelfMomentsOfExponential(rate, h, MomentsOfExponential(rate, h));
    for (int i = 0; i < kElementModes; ++i) {
      for (int j = 0; j < kElementModes; ++j) {
        double sum = 0.0;
        const QuadratureRule outer = GaussLegendreRule(24, 0.0, h);
        for (std::size_t a = 0; a < outer.nodes.size(); ++a) {
          const double x = outer.nodes[a];
          for (const auto& inner : {GaussLegendreRule(16, 0.0, x), GaussLegendreRule(16, x, h)}) {
            for (std::size_t b = 0; b < inner.nodes.size(); ++b) {
              sum += outer.weights[a] * inner.weights[b] * Legendre(i, x, h) *
                     Legendre(j, inner.nodes[b], h) * std::exp(-rate * std::abs(x - inner.nodes[b]));
            }
          }
        }
        EXPECT_NEAR(self[i * kElementModes + j], sum, 1e-9) << rate << ' ' << i << ' ' << j;
      }
    }
  }
}

// Source: Chandrasekhar's H function, from its own equation (h_function.h).
TEST(ExactLayer, MatchesChandrasekharsHFunction) {
  const ExactFaces faces = MakeExactFaces(1.0, 1.0, 1.0, false, true);
  for (const double albedo : {0.3, 0.7, 0.99}) {
    ExactLayer layer;
    layer.albedo = albedo;
    EXPECT_NEAR(SolveExactLayer(faces, layer).r_normal,
                1.0 - reference::HFunction(1.0, albedo) * std::sqrt(1.0 - albedo), 1e-4)
        << albedo;
  }
}

// A half-space with albedo 1 returns all light. Source: conservation of energy.
TEST(ExactLayer, ConservativeHalfSpaceReturnsEverything) {
  const ExactFaces faces = MakeExactFaces(1.4, 1.38, 1.38, false, true);
  const ExactResponses r = SolveExactLayer(faces, ExactLayer{});
  EXPECT_NEAR(r.r_normal, 1.0, 5e-4);
  EXPECT_NEAR(r.r_down, 1.0, 5e-4);
}

// Without scattering only straight light crosses. Source: Beer's law; E_3 for diffuse light: 2 E_3(1) =
// 0.219384. (Abramowitz and Stegun, table 5.4: E_3(1) = 0.1096920.)
TEST(ExactLayer, WithoutScatteringIsBeersLaw) {
  const ExactFaces faces = MakeExactFaces(1.0, 1.0, 1.0, false, false);
  ExactLayer layer;
  layer.albedo = 0.0;
  const ExactResponses r = SolveExactLayer(faces, layer);
  EXPECT_NEAR(r.t_ballistic, std::exp(-1.0), 1e-12);
  EXPECT_NEAR(r.t_down, 2.0 * 0.1096920, 1e-5);
  EXPECT_EQ(r.r_normal, 0.0);
}

class EveryFrequency : public ::testing::TestWithParam<double> {};

// Source: the same solver at twice to three times the resolution of everything.
TEST_P(EveryFrequency, DefaultsAreNearTheLimit) {
  const double kappa = GetParam();
  const ExactFaces coarse = MakeExactFaces(1.0, 1.4, 1.38, false, false);
  const ExactFaces fine = MakeExactFaces(1.0, 1.4, 1.38, false, false, kFine);
  ExactLayer layer;
  layer.thickness = 1.5;
  layer.albedo = 0.99;
  layer.kappa = kappa;
  layer.below = {.extinction = 0.5, .albedo = 0.97, .index = 1.38 / 1.4};
  const ExactResponses a = SolveExactLayer(coarse, layer), b = SolveExactLayer(fine, layer, kFine);
  EXPECT_NEAR(a.r_normal, b.r_normal, 1e-4);
  EXPECT_NEAR(a.t_normal, b.t_normal, 1e-4);
  EXPECT_NEAR(a.r_up, b.r_up, 5e-4);
  EXPECT_NEAR(a.t_up, b.t_up, 5e-4);
  EXPECT_NEAR(a.r_normal_single, b.r_normal_single, 1e-4);
}
INSTANTIATE_TEST_SUITE_P(Kappas, EveryFrequency, ::testing::Values(0.0, 0.1, 1.0, 4.0, 15.0));

// A slab between equal media is the same from both sides. Source: symmetry.
TEST(ExactLayer, SymmetricSlabIsTheSameFromBothSides) {
  const ExactFaces faces = MakeExactFaces(1.38, 1.4, 1.38, false, false);
  ExactLayer layer;
  layer.thickness = 2.0;
  layer.albedo = 0.9;
  layer.kappa = 1.3;
  const ExactResponses r = SolveExactLayer(faces, layer);
  EXPECT_NEAR(r.r_up, r.r_down, 1e-12);
  EXPECT_NEAR(r.t_up, r.t_down, 1e-12);
}

// Black tape takes what the surface would mirror back. Source: the definition.
TEST(ExactLayer, BlackTapeReturnsLess) {
  ExactLayer layer;
  layer.thickness = 1.5;
  layer.albedo = 0.99;
  const double free = SolveExactLayer(MakeExactFaces(1.0, 1.4, 1.38, false, false), layer).r_up;
  const double black = SolveExactLayer(MakeExactFaces(1.0, 1.4, 1.38, true, false), layer).r_up;
  EXPECT_LT(black, free - 0.1);
  EXPECT_GT(black, 0.0);
}

}  // namespace
}  // namespace dermap
