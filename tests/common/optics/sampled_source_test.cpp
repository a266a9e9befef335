// SPDX-License-Identifier: Apache-2.0
// Interpolated sources against the source itself, between the samples.
#include "common/optics/sampled_source.h"

#include <gtest/gtest.h>

#include <cmath>

#include "common/optics/exact_profile_source.h"
#include "common/optics/profile_table.h"

namespace dermap {
namespace {

// Source: the source that was sampled, asked directly, at the table's frequencies. T1- oscillates about 0 at
// high frequencies, where it carries nothing, and is worst.
TEST(SampledSource, AgreesWithItsSourceBetweenSamples) {
  const ExactProfileSource exact;
  EpidermisOptics epidermis{.layer = {.mu_a = 0.0, .mu_s_reduced = 6.0, .n = 1.4}};
  DermisOptics dermis{.layer = {.mu_a = 0.0, .mu_s_reduced = 3.0, .n = 1.38}};
  const auto k = TableFrequencies_per_mm();
  const SampledSource sampled(exact, epidermis, dermis, k, kTableMinMuA, kTableMaxMuA);
  for (const double mu_a : {0.006, 0.21, 3.3, 47.0}) {
    epidermis.layer.mu_a = dermis.layer.mu_a = mu_a;
    const auto a = sampled.Epidermis(epidermis, k), b = exact.Epidermis(epidermis, k);
    const auto c = sampled.Dermis(dermis, k), d = exact.Dermis(dermis, k);
    EXPECT_NEAR(a.t_ballistic / b.t_ballistic, 1.0, 2e-3);
    const auto same = [&](const std::vector<double>& one, const std::vector<double>& other, const char* what,
                          double tolerance = 1e-3) {
      EXPECT_NEAR(one[0] / other[0], 1.0, 1e-3) << what << mu_a;
      for (std::size_t i = 0; i < k.size(); ++i) {
        EXPECT_NEAR(one[i], other[i], tolerance * other[0]) << what << mu_a << ' ' << k[i];
      }
    };
    same(a.r_forward, b.r_forward, "R1+ ");
    same(a.t_forward, b.t_forward, "T1+ ");
    same(a.r_backward, b.r_backward, "R1- ");
    same(a.t_backward, b.t_backward, "T1- ", 1.5e-2);
    same(a.r_single, b.r_single, "single ");
    same(c.r_diffuse, d.r_diffuse, "R2 diffuse ");
    same(c.r_normal, d.r_normal, "R2 normal ");
  }
}

}  // namespace
}  // namespace dermap
