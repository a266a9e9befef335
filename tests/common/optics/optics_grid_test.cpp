// SPDX-License-Identifier: Apache-2.0
// The optics command's rows: read, checked, evaluated against the judges, written.
#include "common/optics/optics_grid.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "common/core/error.h"
#include "tests/reference/adding_doubling.h"

namespace dermap {
namespace {

std::vector<OpticsRow> Read(const std::string& text) {
  std::istringstream in(text);
  return ReadOpticsGrid(in, "grid.csv", TissueConfig{});
}

std::string Complaint(const std::string& text) {
  try {
    Read(text);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

const std::string kHeader = "wavelength_nm,mu_a_epidermis_per_mm,mu_a_dermis_per_mm\n";

// Source: the defaults of [tissue] and [D08 eq. 12] at 550 nm by hand: 14.74 * 550^-0.22 + 2.2e11 * 550^-4
// = 6.0818.
TEST(OpticsGrid, AbsentColumnsFollowTheConfiguration) {
  const auto rows = Read("# a comment\n" + kHeader + "550, 0.5 ,0.1\r\n\n");
  ASSERT_EQ(rows.size(), 1u);
  EXPECT_NEAR(rows[0].mu_s_reduced_epidermis, 6.0818, 2e-3);
  EXPECT_NEAR(rows[0].mu_s_reduced_dermis, 3.0409, 1e-3);
  EXPECT_EQ(rows[0].epidermis_thickness_mm, 0.25);
  EXPECT_EQ(rows[0].junction_absorbance, TissueConfig{}.junction_absorbance);
}

// Source: the format. Columns may stand in any order.
TEST(OpticsGrid, ColumnsAreFoundByName) {
  const auto rows =
      Read("mu_a_dermis_per_mm,epidermis_thickness_mm,wavelength_nm,mu_a_epidermis_per_mm\n1,0.1,500,2\n");
  EXPECT_EQ(rows[0].mu_a_dermis, 1.0);
  EXPECT_EQ(rows[0].mu_a_epidermis, 2.0);
  EXPECT_EQ(rows[0].wavelength_nm, 500.0);
  EXPECT_EQ(rows[0].epidermis_thickness_mm, 0.1);
}

// Source: the rule that what is wrong is named with its line.
TEST(OpticsGrid, WhatIsWrongIsNamedByLine) {
  using ::testing::AllOf;
  using ::testing::HasSubstr;
  EXPECT_THAT(Complaint(kHeader + "550,0.5,0.1\n550,x,0.1\n"),
              AllOf(HasSubstr("grid.csv line 3"), HasSubstr("'x'")));
  EXPECT_THAT(Complaint(kHeader + "550,-1,0.1\n"), AllOf(HasSubstr("line 2"), HasSubstr("-1")));
  EXPECT_THAT(Complaint(kHeader + "550,nan,0.1\n"), HasSubstr("line 2"));
  EXPECT_THAT(Complaint(kHeader + "20,1,0.1\n"), AllOf(HasSubstr("line 2"), HasSubstr("350")));
  EXPECT_THAT(Complaint(kHeader + "550,1\n"), HasSubstr("2 values"));
  EXPECT_THAT(Complaint(kHeader + "550,1,\n"), HasSubstr("no number"));
  EXPECT_THAT(Complaint("wavelength_nm,colour\n"), HasSubstr("'colour'"));
  EXPECT_THAT(Complaint("wavelength_nm,mu_a_dermis_per_mm\n1,2\n"), HasSubstr("mu_a_epidermis_per_mm"));
  EXPECT_THAT(Complaint("wavelength_nm,wavelength_nm\n"), HasSubstr("twice"));
  EXPECT_THAT(Complaint(""), HasSubstr("no row"));
  EXPECT_THAT(Complaint(kHeader), HasSubstr("no row"));
}

// Source: adding-doubling. Each row knows its neighbours, so it is better than tables: 0.4 % is held.
TEST(OpticsGrid, ExactRowsAgreeWithAddingDoubling) {
  std::string text = "wavelength_nm,mu_a_epidermis_per_mm,mu_a_dermis_per_mm,junction_absorbance\n";
  for (const char* skin :
       {"0.02,0.02,0", "0.02,2,0", "0.5,0.5,1.2", "2,0.02,0", "2,30,0", "20,1,0.3", "80,1,0"}) {
    for (const char* nm : {"400,", "560,", "720,"}) text += nm + std::string(skin) + "\n";
  }
  const auto rows = Read(text);
  const auto results = EvaluateOpticsGrid(*MakeProfileSource("exact"), TissueConfig{}, rows, {});
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const OpticsRow& row = rows[i];
    const reference::Layer upper{.thickness_mm = 0.25,
                                 .mu_a = row.mu_a_epidermis,
                                 .mu_s = row.mu_s_reduced_epidermis,
                                 .n = 1.4,
                                 .absorber_below = row.junction_absorbance};
    const reference::Layer lower{.mu_a = row.mu_a_dermis, .mu_s = row.mu_s_reduced_dermis, .n = 1.38};
    const auto judge = reference::NormalIncidenceTotals({1.0, {upper, lower}, 1.38}, 10);
    EXPECT_NEAR(results[i].reflectance / judge.reflectance, 1.0, 4e-3)
        << row.wavelength_nm << ' ' << row.mu_a_epidermis << ' ' << row.mu_a_dermis;
  }
}

// Source: the layout of OUT.csv.
TEST(OpticsGrid, WritesEveryColumn) {
  const auto rows = Read(kHeader + "550,0.5,0.1\n");
  const std::vector<double> radii{0.03, 0.5};
  for (const std::string& name : ProfileSourceNames()) {
    const auto results = EvaluateOpticsGrid(*MakeProfileSource(name), TissueConfig{}, rows, radii);
    std::ostringstream out;
    WriteOpticsGrid(out, rows, results, radii);
    EXPECT_THAT(out.str(), ::testing::HasSubstr("reflectance,R1,T1,R2,R(0.03),R(0.5)\n550,0.5,0.1,"));
    EXPECT_GT(results[0].radial[0], results[0].radial[1]) << name;
    EXPECT_GT(results[0].radial[1], 0.0) << name;
  }
}

}  // namespace
}  // namespace dermap
