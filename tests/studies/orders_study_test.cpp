// SPDX-License-Identifier: Apache-2.0
// How many terms of the series a band needs.
#include "studies/orders_study.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "common/files/atomic_file.h"
#include "tests/common/files/temporary_folder.h"

namespace dermap {
namespace {

// Source: [D08 7] takes 4 terms for blue light and 5 for green and red to hold 99 % of the light; and what a
// series is: every further term leaves less, dark skin needs fewer than light skin.
TEST(OrdersStudy, NeedsAboutAsManyTermsAsPublished) {
  const OrdersStudy study = RunOrdersStudy({.quick = true}, {});
  for (const Verdict& verdict : study.verdicts) EXPECT_TRUE(verdict.holds()) << verdict.claim;
  ASSERT_EQ(study.curves.size(), 6u);
  for (const OrdersStudy::Curve& curve : study.curves) {
    for (std::size_t t = 1; t < curve.uniform.size(); ++t) EXPECT_LE(curve.uniform[t], curve.uniform[t - 1]);
    EXPECT_LT(curve.closed[curve.automatic_terms], 1e-3);
  }
  const OrdersStudy::Curve &light = study.curves[0], &dark = study.curves[3];
  EXPECT_EQ(light.wavelength_nm, 450.0);
  EXPECT_NEAR(light.terms_99, 4, 1);
  EXPECT_NEAR(study.curves[1].terms_99, 5, 1);
  EXPECT_LT(dark.terms_99, light.terms_99);
  EXPECT_LT(dark.automatic_terms, light.automatic_terms);
}

TEST(OrdersStudy, WritesItsFiles) {
  const OrdersStudy study = RunOrdersStudy({.quick = true}, {});
  const TemporaryFolder folder;
  WriteOrdersStudy(folder.path() / "study", study);
  const auto json = nlohmann::json::parse(ReadTextFile(folder.path() / "study" / "orders.json"));
  EXPECT_EQ(json["curves"].size(), 6u);
  EXPECT_EQ(json["curves"][0]["uniform"].size(), json["curves"][0]["window_closed"].size());
  EXPECT_NE(ReadTextFile(folder.path() / "study" / "orders.svg").find("</svg>"), std::string::npos);
}

}  // namespace
}  // namespace dermap
