// SPDX-License-Identifier: Apache-2.0
// Columns and defaults of the optics grid, as DESIGN and docs/formats.md define them.
#include "common/files/optics_grid.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/core/error.h"
#include "common/files/atomic_file.h"
#include "tests/common/files/temporary_folder.h"

namespace dermap {
namespace {

using ::testing::HasSubstr;

class Grid : public ::testing::Test {
 protected:
  OpticsGrid Read(const std::string& text, const TissueConfig& config = {}) {
    WriteFileAtomically(path_, std::string_view(text));
    return ReadOpticsGrid(path_, config);
  }
  std::string Refusal(const std::string& text) {
    return SentenceOf<InputError>([&] { Read(text); });
  }
  TemporaryFolder folder_;
  std::filesystem::path path_ = folder_.path() / "grid.csv", out_ = folder_.path() / "out.csv";
};

// [D08 eq. 12] at 500 nm: 14.74 * 500^-0.22 + 2.2e11 * 500^-4 = 7.2765 per mm, half of it in the dermis.
TEST_F(Grid, AbsentColumnsFollowFromTheConfiguration) {
  TissueConfig config;
  config.junction_absorbance = 0.3;
  config.epidermis_thickness_mm = 0.4;
  const SkinRow row =
      Read("mu_a_dermis_per_mm,wavelength_nm,mu_a_epidermis_per_mm\n0.2,500,1.5\n", config).rows.at(0);
  EXPECT_EQ(row.mu_a_epidermis, 1.5);
  EXPECT_EQ(row.mu_a_dermis, 0.2);
  EXPECT_NEAR(row.mu_s_reduced_epidermis, 7.2765, 1e-3);
  EXPECT_NEAR(row.mu_s_reduced_dermis, 0.5 * row.mu_s_reduced_epidermis, 1e-12);
  EXPECT_EQ(row.junction_absorbance, 0.3);
  EXPECT_EQ(row.epidermis_thickness_mm, 0.4);
}

TEST_F(Grid, ColumnsGoBeforeTheConfiguration) {
  const SkinRow row = Read(
                          "wavelength_nm,mu_a_epidermis_per_mm,mu_a_dermis_per_mm,junction_absorbance,"
                          "mu_s_reduced_epidermis_per_mm,mu_s_reduced_dermis_per_mm,epidermis_thickness_mm\n"
                          "500,1,2,0.1,5,4,0.3\n")
                          .rows.at(0);
  EXPECT_EQ(row.junction_absorbance, 0.1);
  EXPECT_EQ(row.mu_s_reduced_epidermis, 5.0);
  EXPECT_EQ(row.mu_s_reduced_dermis, 4.0);
  EXPECT_EQ(row.epidermis_thickness_mm, 0.3);
}

// Every refusal names the line, the column, what was found and what was expected.
TEST_F(Grid, RefusesByLineAndColumn) {
  const std::string header = "wavelength_nm,mu_a_epidermis_per_mm,mu_a_dermis_per_mm\n";
  EXPECT_THAT(Refusal(header + "500,1,1\n500,x,1\n"), HasSubstr("line 3: mu_a_epidermis_per_mm is 'x'"));
  EXPECT_THAT(Refusal(header + "500,1,nan\n"), HasSubstr("line 2: mu_a_dermis_per_mm is 'nan'"));
  EXPECT_THAT(Refusal(header + "500,-1,1\n"),
              HasSubstr("line 2: mu_a_epidermis_per_mm is -1; expected 0 to 1000"));
  EXPECT_THAT(Refusal(header + "5000,1,1\n"), HasSubstr("wavelength_nm is 5000; expected 350 to 1000"));
  EXPECT_THAT(Refusal(header), HasSubstr("no rows"));
  EXPECT_THAT(Refusal("wavelength_nm,mu_a_epidermis_per_mm\n500,1\n"),
              HasSubstr("mu_a_dermis_per_mm is missing"));
  EXPECT_THAT(Refusal("wavelength,mu_a_epidermis_per_mm,mu_a_dermis_per_mm\n500,1,1\n"),
              HasSubstr("did you mean wavelength_nm"));
  EXPECT_THAT(Refusal("wavelength_nm,wavelength_nm,mu_a_epidermis_per_mm,mu_a_dermis_per_mm\n1,1,1,1\n"),
              HasSubstr("twice"));
}

// The grid as it was typed, then the results in the order that DESIGN gives them.
TEST_F(Grid, ResultsStandBehindTheGivenColumns) {
  const OpticsGrid grid = Read("mu_a_dermis_per_mm,wavelength_nm,mu_a_epidermis_per_mm\n0.20,5e2,1\n");
  SkinResponses r;
  r.reflectance = 0.25;
  r.r1 = 0.125;
  r.t1 = 0.5;
  r.r2 = 0.75;
  r.radial_per_mm2 = {2.0, 1.0};
  WriteOpticsGrid(out_, grid, {r}, ParseRadii("0.03, .50"), {});
  EXPECT_EQ(ReadTextFile(out_),
            "mu_a_dermis_per_mm,wavelength_nm,mu_a_epidermis_per_mm,reflectance,R1,T1,R2,R(0.03),R(.50)\n"
            "0.20,5e2,1,0.25,0.125,0.5,0.75,2,1\n");
}

TEST(ParseRadii, RefusesWhatIsNoRadius) {
  EXPECT_EQ(ParseRadii("0.03,1")[1].radius_mm, 1.0);
  for (const char* text : {"", "0.03,", "0", "-1", "100", "0.1;0.2", "nan"}) {
    EXPECT_THROW(ParseRadii(text), InputError) << text;
  }
}

}  // namespace
}  // namespace dermap
