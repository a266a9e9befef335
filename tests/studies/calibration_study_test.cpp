// SPDX-License-Identifier: Apache-2.0
// The study of the calibration, with few rigs: its limits are those that the calibration is held to, its
// file's keys those of docs/formats.md.
#include "studies/calibration_study.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "common/core/error.h"
#include "common/files/atomic_file.h"
#include "studies/calibration_judge.h"
#include "tests/common/files/temporary_folder.h"

namespace dermap {
namespace {

// By hand: errors of opposite sign are noise, those of one sign bias; chi2 (4 + 1 + 1 + 4) / 4 of what is
// said.
TEST(JudgePatches, TellsBiasFromNoise) {
  CalibrationStudyRig rig;
  JudgePatches({{{0.002, 0.001}, {0.001, 0.001}}, {{-0.001, 0.001}, {0.001, 0.0005}}}, {0.18, 0.9}, rig);
  EXPECT_DOUBLE_EQ(rig.bias, 0.001);
  EXPECT_DOUBLE_EQ(rig.bias_mid_gray, 0.0005);
  EXPECT_DOUBLE_EQ(rig.error_once, 0.002);
  EXPECT_DOUBLE_EQ(rig.error_mid_gray_once, 0.002);
  EXPECT_DOUBLE_EQ(rig.chi2_once, 2.5);
}

TEST(CalibrationStudy, HoldsItsLimitsOnTwoRigsAndGoesOnWhereItWas) {
  const TemporaryFolder folder;
  EXPECT_EQ(RunCalibrationStudy(folder.path(), {1, 7}, {}).resumed, 0);
  const CalibrationStudy study = RunCalibrationStudy(folder.path(), {2, 7}, {});
  EXPECT_EQ(study.resumed, 1);
  ASSERT_EQ(study.rigs.size(), 2u);
  EXPECT_EQ(study.failures, 0);
  EXPECT_LT(study.bias.worst, kBiasLimit);
  EXPECT_LT(study.bias_mid_gray.worst, kMidGrayLimit);
  // Errors of single sessions are as large as these say: chi2 of 12 draws of the gray card, and of 192
  // fields.
  EXPECT_GT(study.chi2_once_mean, 0.3);
  EXPECT_LT(study.chi2_once_mean, 2.5);
  EXPECT_EQ(study.within_chi2, 2);
  EXPECT_EQ(study.within_alignment, 2);
  WriteCalibrationStudy(folder.path(), study);
  const auto json = nlohmann::json::parse(ReadTextFile(folder.path() / "calibration.json"));
  for (const char* key : {"bias", "bias_mid_gray", "chi2_per_dof", "alignment_error_px", "dropped_bands"}) {
    EXPECT_TRUE(json[key]["median"].is_number()) << key;
    EXPECT_TRUE(json[key]["worst"].is_number()) << key;
  }
  // Rigs of another seed are no part of this study.
  EXPECT_THROW(RunCalibrationStudy(folder.path(), {2, 8}, {}), InputError);
}

}  // namespace
}  // namespace dermap
