// SPDX-License-Identifier: Apache-2.0
// Fresnel reflection against closed forms and published numbers.
#include "common/optics/fresnel.h"

#include <gtest/gtest.h>

#include <cmath>

namespace dermap {
namespace {

// ((n - 1)/(n + 1))^2 at normal incidence: 0.04 for glass of 1.5, 0.027778 for skin of 1.4; the same from
// both sides.
TEST(Fresnel, NormalIncidence) {
  EXPECT_NEAR(FresnelReflectance(1.0, 1.0, 1.5), 0.04, 1e-15);
  EXPECT_NEAR(FresnelReflectance(1.0, 1.5, 1.0), 0.04, 1e-15);
  EXPECT_NEAR(FresnelReflectance(1.0, 1.0, 1.4), 0.0277777778, 1e-10);
  EXPECT_EQ(FresnelReflectance(1.0, 1.4, 1.4), 0.0);
}

// Brewster's law: at tan(angle) = n light polarised in the plane of incidence is not reflected, and the other
// is by
// ((n^2 - 1)/(n^2 + 1))^2; unpolarised light by half of that.
TEST(Fresnel, BrewstersAngle) {
  const double n = 1.5;
  const double s = (n * n - 1.0) / (n * n + 1.0);
  EXPECT_NEAR(FresnelReflectance(1.0 / std::sqrt(1.0 + n * n), 1.0, n), 0.5 * s * s, 1e-15);
}

// Snell: nothing passes beyond the critical angle, everything is symmetric below it.
TEST(Fresnel, TotalReflectionAndReversedRays) {
  const double critical_cos = std::sqrt(1.0 - 1.0 / (1.4 * 1.4));
  EXPECT_EQ(FresnelReflectance(critical_cos - 1e-9, 1.4, 1.0), 1.0);
  EXPECT_LT(FresnelReflectance(critical_cos + 1e-3, 1.4, 1.0), 1.0);
  EXPECT_EQ(FresnelReflectance(0.0, 1.0, 1.4), 1.0);
  for (double cos_air = 0.05; cos_air <= 1.0; cos_air += 0.05) {
    const double cos_skin = std::sqrt(1.0 - (1.0 - cos_air * cos_air) / (1.4 * 1.4));
    EXPECT_NEAR(FresnelReflectance(cos_air, 1.0, 1.4), FresnelReflectance(cos_skin, 1.4, 1.0), 1e-13);
  }
}

// Walsh 1926, the closed form of the reflection of diffuse light from outside, as in Judd, J. Res. NBS 29,
// 329 (1942).
double Walsh(double n) {
  const double n2 = n * n, n4 = n2 * n2;
  return 0.5 + (n - 1.0) * (3.0 * n + 1.0) / (6.0 * (n + 1.0) * (n + 1.0)) +
         n2 * (n2 - 1.0) * (n2 - 1.0) / std::pow(n2 + 1.0, 3) * std::log((n - 1.0) / (n + 1.0)) -
         2.0 * n2 * n * (n2 + 2.0 * n - 1.0) / ((n2 + 1.0) * (n4 - 1.0)) +
         8.0 * n4 * (n4 + 1.0) / ((n2 + 1.0) * (n4 - 1.0) * (n4 - 1.0)) * std::log(n);
}

TEST(DiffuseFresnel, MatchesWalshsClosedForm) {
  for (const double n : {1.02, 1.05, 1.33, 1.4, 1.5, 2.0, 3.0}) {
    EXPECT_NEAR(DiffuseFresnelReflectance(1.0, n), Walsh(n), 1e-9) << n;
    EXPECT_NEAR(DiffuseFresnelReflectance(n, 1.0), 1.0 - (1.0 - Walsh(n)) / (n * n), 1e-9) << n;
  }
}

// Duntley, J. Opt. Soc. Am. 32, 61 (1942), and Judd 1942: at n = 1.5, 0.0918 of diffuse light from outside
// and 0.596 from inside (the constants of Saunderson's correction).
TEST(DiffuseFresnel, PublishedValuesForGlass) {
  EXPECT_NEAR(DiffuseFresnelReflectance(1.0, 1.5), 0.0918, 5e-5);
  EXPECT_NEAR(DiffuseFresnelReflectance(1.5, 1.0), 0.596, 5e-4);
}

// Plain midpoint sum over the angles; also where the indices nearly agree, as at the junction of epidermis
// and dermis.
TEST(DiffuseFresnel, MatchesMidpointSum) {
  for (const auto& [n_from, n_to] :
       {std::pair{1.4, 1.38}, {1.38, 1.4}, {1.4, 1.399}, {1.4, 1.0}, {1.34, 1.4}}) {
    constexpr int kSteps = 400000;
    double sum = 0.0;
    for (int i = 0; i < kSteps; ++i) {
      const double mu = (i + 0.5) / kSteps;
      sum += 2.0 * mu * FresnelReflectance(mu, n_from, n_to) / kSteps;
    }
    EXPECT_NEAR(DiffuseFresnelReflectance(n_from, n_to), sum, 1e-8) << n_from << " to " << n_to;
  }
  EXPECT_EQ(DiffuseFresnelReflectance(1.4, 1.4), 0.0);
}

}  // namespace
}  // namespace dermap
