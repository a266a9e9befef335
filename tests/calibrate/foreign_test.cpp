// SPDX-License-Identifier: Apache-2.0
// Other people's files: raw files with a TOML, stacks that are calibrated already.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <opencv2/imgcodecs.hpp>

#include "acquire/simulated/dng_writer.h"
#include "calibrate/calibrate.h"
#include "calibrate/folder_session.h"
#include "calibrate/import_stack.h"
#include "common/core/error.h"
#include "common/files/atomic_file.h"
#include "tests/calibrate/simulated_session.h"

namespace dermap {
namespace {

using ::testing::HasSubstr;

class Foreign : public ::testing::Test {
 protected:
  Foreign() {
    folder_ =
        std::filesystem::temp_directory_path() /
        ("dermap_foreign_" + std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()));
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
  }
  ~Foreign() override { std::filesystem::remove_all(folder_); }
  std::filesystem::path folder_;
};

std::string ErrorOf(const std::function<void()>& body) {
  try {
    body();
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

// The bench's 0.5, from files that nobody wrote a manifest for; exposure and ISO come from the files
// themselves.
TEST_F(Foreign, RawFilesAreCalibratedByASmallToml) {
  SimulatedSession simulated("gray_50.toml", {}, [](PlanConfig& plan) { plan.exposures.resize(1); });
  std::string toml = "gray_card_region = [0.80, 0.25, 0.14, 0.5]\nlight_angle_deg = 5\n";
  for (const FrameRecord& frame : simulated.session().frames) {
    DngMetadata metadata;
    metadata.exposure_ms = frame.exposure_ms;
    metadata.iso = frame.iso;
    const std::string name = "IMG_" + std::to_string(frame.number) + ".dng";
    WriteFileAtomically(folder_ / name,
                        EncodeDng(simulated.bench().Expose(simulated.ShotOf(frame)), metadata));
    toml += "[[frame]]\nfile = \"" + name + "\"\nrole = \"" + std::string(RoleName(frame.role)) + "\"\n";
    if (frame.role != FrameRole::kBlack) toml += "wavelength_nm = 450\n";
  }
  WriteFileAtomically(folder_ / "files.toml", toml);
  const Session session = ReadFolderSession(folder_ / "files.toml");
  EXPECT_EQ(session.rig.light_angle_deg, 5.0);
  ASSERT_EQ(session.frames.size(), 3u);
  EXPECT_EQ(session.frames[0].iso, 125);
  EXPECT_NEAR(session.frames[0].exposure_ms, 10.0, 1e-3);
  CalibrationOptions options;
  options.verify_hashes = false;
  EXPECT_NEAR(CalibrateSession(session, options).bands[0].median_reflectance, 0.5, 0.0015);
}

// By definition of the errors: they name the file and the remedy.
TEST_F(Foreign, TomlWithoutSenseIsRefused) {
  const auto error = [&](const std::string& toml) {
    WriteFileAtomically(folder_ / "files.toml", toml);
    return ErrorOf([&] { ReadFolderSession(folder_ / "files.toml"); });
  };
  EXPECT_THAT(error(""), HasSubstr("no frames"));
  EXPECT_THAT(error("[[frame]]\nfile = \"a.dng\"\nrole = \"sky\"\n"),
              HasSubstr("expected black, spectralon or skin"));
  EXPECT_THAT(error("[[frame]]\nfile = \"a.dng\"\nrole = \"black\"\n"), HasSubstr("no such file"));
  EXPECT_THAT(error("[[frame]]\nfle = \"a.dng\"\nrole = \"black\"\n"), HasSubstr("file"));
}

// The values written: 16-bit pages by 1/65535, in any order of wavelengths.
TEST_F(Foreign, TiffPagesBecomeBands) {
  std::vector<cv::Mat> pages;
  for (const int value : {10000, 40000}) pages.emplace_back(24, 32, CV_16U, cv::Scalar(value));
  cv::imwritemulti((folder_ / "stack.tif").string(), pages);
  ImportOptions options;
  options.wavelengths_nm = {650.0, 450.0};
  options.fwhm_nm = {12.0};
  options.pixel_size_mm = 0.05;
  options.relative_sigma = 0.01;
  const auto stack = ImportStack({folder_ / "stack.tif"}, options);
  ASSERT_EQ(stack.bands.size(), 2u);
  EXPECT_EQ(stack.bands[0].wavelength_nm, 450.0);
  EXPECT_EQ(stack.bands[1].fwhm_nm, 12.0);
  EXPECT_NEAR(stack.reflectance[0](3, 5), 40000.0 / 65535, 1e-6);
  EXPECT_NEAR(stack.sigma[1](3, 5), 100.0 / 65535, 1e-7);
  EXPECT_EQ(stack.pixel_size_mm, 0.05);
  options.wavelengths_nm = {650.0};
  EXPECT_THAT(ErrorOf([&] { ImportStack({folder_ / "stack.tif"}, options); }), HasSubstr("2 planes"));
  options.wavelengths_nm = {650.0, 450.0};
  options.scale = 1.0;
  EXPECT_THAT(ErrorOf([&] { ImportStack({folder_ / "stack.tif"}, options); }), HasSubstr("--scale"));
}

// What went out as ENVI comes back, with what was added.
TEST_F(Foreign, EnviStacksAreTakenOver) {
  ReflectanceStack stack;
  stack.bands = {{500.0, 10.0}, {600.0, 10.0}};
  stack.reflectance = {PlaneF(8, 6, 0.3f), PlaneF(8, 6, 0.4f)};
  WriteReflectanceStack(folder_ / "a.hdr", stack);
  ImportOptions options;
  options.geometry = Geometry::kFactor0_30;
  options.pixel_size_mm = 0.1;
  const auto back = ImportStack({folder_ / "a.hdr"}, options);
  EXPECT_EQ(back.reflectance[1](7, 5), 0.4f);
  EXPECT_EQ(back.geometry, Geometry::kFactor0_30);
  EXPECT_EQ(back.pixel_size_mm, 0.1);
}

}  // namespace
}  // namespace dermap
