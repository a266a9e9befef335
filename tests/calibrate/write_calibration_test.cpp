// SPDX-License-Identifier: Apache-2.0
// What lands on disk, read back. Expected: the contents of the result that was written.
#include "calibrate/write_calibration.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "common/files/atomic_file.h"
#include "tests/calibrate/simulated_session.h"

namespace dermap {
namespace {

TEST(WriteCalibration, LeavesStackRecordAndPictures) {
  SimulatedSession simulated("checker.toml", {}, [](PlanConfig& plan) { plan.exposures.resize(2); });
  const auto result = CalibrateFrames(simulated.session(), simulated.Reader(), {});
  const auto folder = std::filesystem::temp_directory_path() / "dermap_write_calibration";
  std::filesystem::remove_all(folder);
  WriteCalibration(folder / "patch.exr", result);

  const ReflectanceStack stack = ReadReflectanceStack(folder / "patch.exr");
  ASSERT_EQ(stack.bands.size(), 2u);
  EXPECT_EQ(stack.bands[0].wavelength_nm, 450.0);
  EXPECT_NEAR(stack.bands[0].fwhm_nm, 10.0, 1e-6);
  EXPECT_EQ(stack.geometry, Geometry::kFactor0_30);
  EXPECT_NEAR(stack.pixel_size_mm.value(), 7.5 / 256, 1e-7);
  EXPECT_EQ(stack.reflectance[1](100, 77), result.stack.reflectance[1](100, 77));
  EXPECT_EQ(stack.sigma[1](100, 77), result.stack.sigma[1](100, 77));
  EXPECT_EQ(stack.valid(0, 128), 0.0f);
  EXPECT_EQ(stack.valid(128, 128), 1.0f);

  const auto record = nlohmann::json::parse(ReadTextFile(folder / "patch.calibration.json"));
  EXPECT_EQ(record["session"], "simulated");
  ASSERT_EQ(record["bands"].size(), 2u);
  for (const char* key : {"wavelength_nm", "frame", "gray_card_drift", "windows", "alignment_shift_px",
                          "median_noise", "saturated_share", "notes"}) {
    EXPECT_TRUE(record["bands"][0].contains(key)) << key;
  }
  EXPECT_NEAR(record["correlation"]["along_x"][0].get<double>(), 1.0, 1e-9);
  ASSERT_EQ(record["pictures"].size(), 4u);
  for (const auto& picture : record["pictures"]) {
    EXPECT_GT(std::filesystem::file_size(folder / picture["file"].get<std::string>()), 1000u)
        << picture["title"];
  }
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    EXPECT_EQ(entry.path().filename().string().find("tmp"), std::string::npos) << entry.path();
  }
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace dermap
