// SPDX-License-Identifier: Apache-2.0
// The inter-scattering series against the geometric sum that it is for uniform skin, and against two-layer
// transforms.
#include "common/transport/scattering_series.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "common/optics/layers.h"
#include "tests/common/transport/scenes.h"

namespace dermap {
namespace {

constexpr int kSize = 48;
constexpr double kPixel_mm = 0.1;
constexpr float kMuAEpidermis = 0.4f, kMuADermis = 0.15f;

PlaneF RenderUniform(const BandTables& tables, double absorbance, int terms, bool close,
                     const PlaneF& light) {
  const Domain domain = MakeDomain(kSize, kSize, 0.0);
  ScatteringSeries series(domain, MakeConvolver(Engine::kCascade, domain, kPixel_mm, Border::kMirror));
  const LocalTotals totals(tables);
  const PlaneF epidermis(kSize, kSize, kMuAEpidermis), dermis(kSize, kSize, kMuADermis);
  const PlaneF transmittance(kSize, kSize, static_cast<float>(std::exp(-absorbance)));
  PlaneF out;
  series.Render({tables, totals, 6.0, 3.0, epidermis, dermis, transmittance, light, false, terms, close},
                out);
  return out;
}

// [D08 eq. 7] for uniform skin: R1+ + sum_n (Tb R2n + T1+ R2d) A^2 T1- (A^2 R1- R2d)^n, n = 0 ... terms - 1,
// written out with the tables' totals; with everything that it leaves out added, the closed form.
TEST(ScatteringSeries, SumsAsManyTermsAsItIsTold) {
  for (const char* source : {"multipole", "exact"}) {
    const BandTables& t = TestTables(650, source);
    const PlaneF light(kSize, kSize, 1.0f);
    const double p = 0.3, a2 = std::exp(-2.0 * p);
    const double r2d = t.r2_diffuse.Total(kMuADermis), r2n = t.r2_normal.Total(kMuADermis);
    double expected = t.r1_forward.Total(kMuAEpidermis);
    double term = (t.t1_ballistic.Total(kMuAEpidermis) * r2n + t.t1_forward.Total(kMuAEpidermis) * r2d) * a2 *
                  t.t1_backward.Total(kMuAEpidermis);
    for (int terms = 0; terms <= 6; ++terms) {
      EXPECT_NEAR(RenderUniform(t, p, terms, false, light)(20, 20), expected, 1e-5)
          << source << ", terms " << terms;
      expected += term;
      term *= a2 * t.r1_backward.Total(kMuAEpidermis) * r2d;
      if (terms > 0) {
        EXPECT_NEAR(RenderUniform(t, p, terms, true, light)(5, 40),
                    t.TotalReflectance(kMuAEpidermis, kMuADermis, p), 1e-5)
            << source << ", closed after " << terms;
      }
    }
  }
}

// Modulated light (spatial frequency domain imaging): on uniform skin the amplitude that comes back is the
// two-layer transform at that frequency, from the optics' own transforms by adding, without Gaussians, tables
// or pixels. The Gaussian sums may be off by 2e-3 of the total.
TEST(ScatteringSeries, ReturnsModulatedLightByTheTwoLayerTransform) {
  const TissueConfig tissue;
  EpidermisOptics upper;
  upper.layer = {kMuAEpidermis, ReducedScatteringEpidermis(650, tissue), tissue.n_epidermis};
  DermisOptics lower;
  lower.layer = {kMuADermis, ReducedScatteringDermis(650, tissue), tissue.n_dermis};
  for (const char* source : {"multipole", "exact"}) {
    for (const int periods : {0, 1, 3, 8}) {
      const double k_per_px = std::numbers::pi * periods / kSize;
      const double k[] = {k_per_px / kPixel_mm};
      const double expected =
          TwoLayerReflectance(TestSource(source).Epidermis(upper, k), TestSource(source).Dermis(lower, k),
                              tissue.junction_absorbance)[0];
      PlaneF light(kSize, kSize);
      for (int y = 0; y < kSize; ++y) {
        for (int x = 0; x < kSize; ++x) light(x, y) = static_cast<float>(std::cos(k_per_px * (y + 0.5)));
      }
      const PlaneF out = RenderUniform(TestTables(650, source), tissue.junction_absorbance, 12, true, light);
      EXPECT_NEAR(out(7, 3) / light(7, 3), expected, 1.5e-3) << source << " at " << k[0] << "/mm";
    }
  }
}

}  // namespace
}  // namespace dermap
