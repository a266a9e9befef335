// SPDX-License-Identifier: Apache-2.0
// The closed forms of the multipole against its sum of dipoles, known totals and Monte Carlo.
#include "common/optics/multipole.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "common/core/error.h"
#include "common/optics/fresnel.h"
#include "common/optics/layers.h"
#include "tests/common/optics/dipole_sum.h"

namespace dermap {
namespace {

const double kTop = BoundaryMismatch(1.4, 1.0);
const double kBottom = BoundaryMismatch(1.4, 1.38);

// Inverse transform of a radial spectrum: 1/(2 pi) int f(k) J0(k r) k dk, trapezoidal.
template <class Spectrum>
double InverseTransform(const Spectrum& f, double r_mm, double k_end_per_mm) {
  const double step = 0.02;
  double sum = 0.0;
  for (double k = step; k < k_end_per_mm; k += step)
    sum += f(k) * std::cyl_bessel_j(0.0, k * r_mm) * k * step;
  return sum / (2.0 * std::numbers::pi);
}

struct Case {
  double mu_a, mu_s_reduced, thickness_mm;
};

// The sum of dipoles [Donner and Jensen 2005], which knows nothing of transforms.
TEST(MultipoleSlab, InverseTransformIsTheSumOfDipoles) {
  for (const auto& c : {Case{0.05, 9.2, 0.25}, {2.0, 6.0, 0.25}, {20.0, 9.0, 0.25}, {0.5, 5.0, 0.35}}) {
    const MultipoleSlab slab({c.mu_a, c.mu_s_reduced, 1.4}, c.thickness_mm, kTop, kBottom);
    const DipoleSlab dipoles{c.mu_a, c.mu_s_reduced, c.thickness_mm, kTop, kBottom};
    const double k_end =
        35.0 / std::min(1.0 / (c.mu_a + c.mu_s_reduced), c.thickness_mm - 1.0 / (c.mu_a + c.mu_s_reduced));
    for (const double r : {0.03, 0.1, 0.3, 0.5, 1.0}) {
      const double reflected = DipoleSumReflectance(dipoles, r);
      const double transmitted = DipoleSumTransmittance(dipoles, r);
      EXPECT_NEAR(InverseTransform([&](double k) { return slab.Reflectance(k); }, r, k_end), reflected,
                  2e-5 + 1e-4 * std::abs(reflected))
          << c.mu_a << " r " << r;
      EXPECT_NEAR(InverseTransform([&](double k) { return slab.Transmittance(k); }, r, k_end), transmitted,
                  2e-5 + 1e-4 * std::abs(transmitted))
          << c.mu_a << " r " << r;
    }
  }
}

// Where the source lies beyond the far face the sum of dipoles turns one pole's sign; so must the closed
// form. Here r is integrated numerically, since the transform of that pole falls off slowly.
TEST(MultipoleSlab, FollowsTheDipolesWhereTheSourceLiesBeyondTheSlab) {
  const DipoleSlab dipoles{0.5, 3.0, 0.25, kTop, kBottom};
  const MultipoleSlab slab({0.5, 3.0, 1.4}, 0.25, kTop, kBottom);
  double total = 0.0, total_reflected = 0.0;
  constexpr double kStep = 0.002;
  for (double r = 0.5 * kStep; r < 12.0; r += kStep) {
    total += 2.0 * std::numbers::pi * r * kStep * DipoleSumTransmittance(dipoles, r);
    total_reflected += 2.0 * std::numbers::pi * r * kStep * DipoleSumReflectance(dipoles, r);
  }
  EXPECT_NEAR(slab.Transmittance(0.0), total, 5e-4);
  EXPECT_NEAR(slab.Reflectance(0.0), total_reflected, 5e-4);
  EXPECT_LT(slab.Transmittance(0.0), 0.0);
}

// Without absorption nothing is lost: diffusion conserves flux, R + T = 1 for light that entered.
TEST(MultipoleSlab, ConservesEnergyWithoutAbsorption) {
  for (const auto& c : {Case{0.0, 200.0, 0.01}, {0.0, 5.0, 0.25}, {0.0, 20.0, 3.0}}) {
    const MultipoleSlab slab({c.mu_a, c.mu_s_reduced, 1.4}, c.thickness_mm, kTop, kBottom);
    EXPECT_NEAR(slab.Reflectance(0.0) + slab.Transmittance(0.0), 1.0, 1e-14) << c.thickness_mm;
  }
  EXPECT_NEAR(DipoleHalfSpace({0.0, 3.0, 1.38}, 1.06).Reflectance(0.0), 1.0, 1e-15);
}

// Jensen, Marschner, Levoy and Hanrahan 2001: the dipole's total diffuse reflectance
// alpha'/2 (1 + exp(-4/3 A sqrt(3 (1 - alpha')))) exp(-sqrt(3 (1 - alpha'))).
TEST(DipoleHalfSpace, TotalIsJensens) {
  for (const double albedo : {0.5, 0.9, 0.99, 0.9999}) {
    const double a = 2.5, root = std::sqrt(3.0 * (1.0 - albedo));
    const double expected = 0.5 * albedo * (1.0 + std::exp(-4.0 / 3.0 * a * root)) * std::exp(-root);
    const DipoleHalfSpace dermis({4.0 * (1.0 - albedo), 4.0 * albedo, 1.38}, a);
    EXPECT_NEAR(dermis.Reflectance(0.0), expected, 1e-14);
  }
}

// A thick slab is a half-space, at every frequency.
TEST(MultipoleSlab, ThickSlabIsTheHalfSpace) {
  const MultipoleSlab slab({0.3, 6.0, 1.4}, 40.0, kTop, kBottom);
  const DipoleHalfSpace half_space({0.3, 6.0, 1.4}, kTop);
  for (const double k : {0.0, 0.1, 1.0, 10.0, 100.0}) {
    EXPECT_NEAR(slab.Reflectance(k), half_space.Reflectance(k), 1e-14);
    EXPECT_NEAR(slab.Transmittance(k), 0.0, 1e-14);
  }
}

// The formula of the source's head comment, evaluated plainly in long double where that neither overflows nor
// cancels.
TEST(MultipoleSlab, IsStableFromThinAndClearToThickAndBlack) {
  for (const double mu_a : {1e-14, 1e-6, 0.02, 8.0, 200.0}) {
    for (const double thickness : {1e-3, 0.25, 5.0}) {
      for (const double k : {0.0, 1e-7, 0.1, 60.0}) {
        const long double sigma_t = mu_a + 50.0L, l = 1.0L / sigma_t,
                          s = std::sqrt(3.0L * mu_a * sigma_t + 1.0L * k * k);
        const long double near = 2.0L * kTop * l / 3.0L, far = 2.0L * kBottom * l / 3.0L;
        const long double expected = 50.0L / sigma_t * std::sinh((thickness + far - l) * s) *
                                     std::cosh(near * s) / std::sinh((thickness + near + far) * s);
        const MultipoleSlab slab({mu_a, 50.0, 1.4}, thickness, kTop, kBottom);
        EXPECT_NEAR(slab.Reflectance(k), static_cast<double>(expected), 1e-12)
            << mu_a << ' ' << thickness << ' ' << k;
      }
    }
  }
  const MultipoleSlab black({200.0, 9.0, 1.4}, 5.0, kTop, kBottom);
  EXPECT_TRUE(std::isfinite(black.Reflectance(1e5)) && std::isfinite(black.Transmittance(1e5)));
}

// Light leaves and never comes from nowhere, as long as the source lies within the slab; and a profile that
// is nowhere negative has its largest transform at k = 0.
TEST(MultipoleSlab, TransformsArePositiveAndFallWithFrequency) {
  for (double mu_a = 0.005; mu_a < 200.0; mu_a *= 1.7) {
    const MultipoleSlab slab({mu_a, 9.2, 1.4}, 0.25, kTop, kBottom);
    double reflectance = slab.Reflectance(0.0), transmittance = slab.Transmittance(0.0);
    EXPECT_LE(reflectance + transmittance, 1.0);
    for (double k = 0.02; k < 100.0; k *= 1.3) {
      EXPECT_GT(slab.Reflectance(k), 0.0);
      EXPECT_GT(slab.Transmittance(k), 0.0);
      EXPECT_LT(slab.Reflectance(k), reflectance);
      EXPECT_LT(slab.Transmittance(k), transmittance);
      reflectance = slab.Reflectance(k);
      transmittance = slab.Transmittance(k);
    }
  }
}

EpidermisOptics Epidermis(double mu_a) {
  return {.layer = {.mu_a = mu_a, .mu_s_reduced = 6.082, .n = 1.4}};
}
DermisOptics Dermis(double mu_a) {
  return {.layer = {.mu_a = mu_a, .mu_s_reduced = 3.041, .n = 1.38}};
}

// The faces differ (air above, dermis below), so light from below meets more internal reflection than light
// from above and crosses less easily; the shortcut takes one number for both. Light from air loses 1 -
// F(normal) = 0.97222 first.
TEST(MultipoleSource, TellsDirectionsApart) {
  const double k[] = {0.0, 1.0};
  const auto own = MakeProfileSource("multipole")->Epidermis(Epidermis(0.5), k);
  const auto shortcut = MakeProfileSource("multipole-symmetric")->Epidermis(Epidermis(0.5), k);
  for (int i = 0; i < 2; ++i) {
    EXPECT_GT(own.r_backward[i], 1.2 * own.r_forward[i] / 0.97222);
    EXPECT_LT(own.t_backward[i], 0.8 * own.t_forward[i] / 0.97222);
    EXPECT_EQ(shortcut.r_forward[i], own.r_forward[i]);
    EXPECT_EQ(shortcut.t_forward[i], own.t_forward[i]);
    EXPECT_NEAR(shortcut.r_backward[i], shortcut.r_forward[i] / 0.972222222, 1e-8);
    EXPECT_NEAR(shortcut.t_backward[i], shortcut.t_forward[i] / 0.972222222, 1e-8);
  }
  EXPECT_EQ(own.t_ballistic, 0.0);
}

// Black tape sends nothing back: without absorption, R1- + T1- is still 1 (what reaches the tape counts as
// transmitted), and R1- is what is left of it with A = 1 at the top, below that under air.
TEST(MultipoleSource, BlackTapeReflectsNothing) {
  const double k[] = {0.0};
  auto optics = Epidermis(0.0);
  const auto free = MakeProfileSource("multipole")->Epidermis(optics, k);
  optics.black_above = true;
  const auto taped = MakeProfileSource("multipole")->Epidermis(optics, k);
  EXPECT_NEAR(taped.r_backward[0] + taped.t_backward[0], 1.0, 1e-12);
  EXPECT_LT(taped.r_backward[0], 0.85 * free.r_backward[0]);
  EXPECT_NEAR(taped.r_backward[0], MultipoleSlab(optics.layer, 0.25, kBottom, 1.0).Reflectance(0.0), 1e-15);
}

// Monte Carlo of homogeneous two-layer skin at 550 nm (isotropic scattering of 6.0823 and 3.0411 per mm,
// dermis mu_a 0.3, 0.25 mm, n = 1.4 over 1.38 under air, P = 0.0175; 6e6 photons, standard error below 0.1
// %). The multipole is not that: these are its errors as first measured, -8...-2 %, +3...+8 %, +16...+28 %,
// +36...+39 %, and must stay as they are, since this source stands for the published optics.
TEST(MultipoleSource, ErrsAgainstMonteCarloAsThePublishedOpticsDo) {
  const struct {
    double mu_a, monte_carlo, lower, upper, symmetric_lower, symmetric_upper;
  } cases[] = {{0.02, 0.42904, -0.08, -0.02, 0.02, 0.17},
               {0.5, 0.28451, 0.03, 0.08, 0.07, 0.24},
               {2.0, 0.13385, 0.16, 0.28, 0.19, 0.29},
               {8.0, 0.04138, 0.36, 0.39, 0.36, 0.39}};
  const double k[] = {0.0};
  for (const auto& c : cases) {
    const auto error = [&](const char* name) {
      const auto source = MakeProfileSource(name);
      return TwoLayerReflectance(source->Epidermis(Epidermis(c.mu_a), k), source->Dermis(Dermis(0.3), k),
                                 0.0175)[0] /
                 c.monte_carlo -
             1.0;
    };
    EXPECT_GT(error("multipole"), c.lower) << c.mu_a;
    EXPECT_LT(error("multipole"), c.upper) << c.mu_a;
    EXPECT_GT(error("multipole-symmetric"), c.symmetric_lower) << c.mu_a;
    EXPECT_LT(error("multipole-symmetric"), c.symmetric_upper) << c.mu_a;
  }
}

// The names of the command line; a name that does not exist is answered with those that do.
TEST(ProfileSources, AreFoundByName) {
  for (const auto& name : ProfileSourceNames()) EXPECT_EQ(MakeProfileSource(name)->Name(), name);
  try {
    MakeProfileSource("monopole");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("multipole-symmetric"), std::string::npos);
  }
}

}  // namespace
}  // namespace dermap
