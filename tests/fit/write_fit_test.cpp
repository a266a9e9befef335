// SPDX-License-Identifier: Apache-2.0
// The fit folder as other tools find it.
#include "fit/write_fit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "common/core/error.h"
#include "common/files/atomic_file.h"
#include "common/files/maps.h"
#include "common/files/stack.h"

namespace dermap {
namespace {

FitResult SmallResult() {
  FitResult result;
  result.bands = {{450, 10}, {560, 10}};
  result.conditions = {0.25, Illumination::kUniform, Tape::kFree, Geometry::kFactor0_30};
  result.maps = ParameterMaps(3, 2, AverageSkin());
  result.sigma = ParameterMaps(3, 2, {0.002, 0, 0, 0, 0});
  result.free_parameters = {Parameter::kC_m};
  result.measured.assign(2, PlaneF(3, 2, 0.40f));
  result.predicted.assign(2, PlaneF(3, 2, 0.41f));
  result.residual.assign(2, PlaneF(3, 2, -0.01f));
  result.flags = Plane<std::uint32_t>(3, 2, kFlagAtBound | kFlagOutsideValidity);
  result.history = {{0, 1, 0.1, 0.05, 20.0}, {1, 7, 0.5, 0.01, 0.9}};
  result.rms_residual = 0.01;
  result.rms_residual_per_band = {0.01, 0.01};
  result.chi2 = 0.9;
  result.seconds = 0.5;
  result.renders = 7;
  result.converged = true;
  result.method = "descent";
  result.profiles = "multipole";
  result.engine = "pyramid";
  result.decisions = {"A sentence with \"quotes\"."};
  return result;
}

class WriteFitTest : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    directory_ =
        std::filesystem::path(::testing::TempDir()) / (std::string("dermap_write_fit_") + info->name());
    std::filesystem::remove_all(directory_);
  }
  void TearDown() override { std::filesystem::remove_all(directory_); }
  std::filesystem::path directory_;
};

// The keys that the project's design promises, and values as given.
TEST_F(WriteFitTest, JsonHasThePromisedKeys) {
  WriteFit(directory_, SmallResult());
  const auto json = nlohmann::json::parse(ReadTextFile(directory_ / "fit.json"));
  for (const char* key : {"rms_residual", "rms_residual_per_band", "chi2", "seconds", "renders", "method",
                          "profiles", "free_parameters", "decisions"})
    EXPECT_TRUE(json.contains(key)) << key;
  EXPECT_EQ(json["renders"], 7);
  EXPECT_EQ(json["free_parameters"], nlohmann::json::array({"C_m"}));
  EXPECT_EQ(json["decisions"][0], "A sentence with \"quotes\".");
  EXPECT_EQ(json["wavelengths_nm"], nlohmann::json::array({450.0, 560.0}));
  EXPECT_EQ(json["history"].size(), 2u);
}

// Maps, sigma, stacks and flags read back as they were, with the conditions of the fit.
TEST_F(WriteFitTest, FilesReadBack) {
  WriteFit(directory_, SmallResult());
  const MapsFile maps = ReadMaps(directory_ / "maps.exr");
  EXPECT_FLOAT_EQ(maps.maps[Parameter::kC_hd](2, 1), 0.03f);
  EXPECT_EQ(maps.illumination, Illumination::kUniform);
  EXPECT_EQ(maps.geometry, Geometry::kFactor0_30);
  ASSERT_EQ(maps.bands.size(), 2u);
  EXPECT_NEAR(maps.pixel_size_mm.value_or(0), 0.25, 1e-7);
  bool found_sigma = false;
  for (const auto& [name, plane] : ReadPlanes(directory_ / "sigma.exr")) {
    if (name != "C_m") continue;
    found_sigma = true;
    EXPECT_FLOAT_EQ(plane(1, 1), 0.002f);
  }
  EXPECT_TRUE(found_sigma);
  EXPECT_FLOAT_EQ(ReadReflectanceStack(directory_ / "predicted.exr").reflectance[1](0, 0), 0.41f);
  EXPECT_FLOAT_EQ(ReadReflectanceStack(directory_ / "residual.exr").reflectance[0](0, 0), -0.01f);
  EXPECT_EQ(ReadPlanes(directory_ / "flags.exr")[0].second(0, 0), 17.0f);
}

// A folder that cannot be made is a storage error (exit code 4).
TEST_F(WriteFitTest, UnwritableFolderIsAStorageError) {
  std::filesystem::create_directories(directory_);
  WriteFileAtomically(directory_ / "file", "not a folder");
  EXPECT_THROW(WriteFit(directory_ / "file" / "fit", SmallResult()), StorageError);
}

}  // namespace
}  // namespace dermap
