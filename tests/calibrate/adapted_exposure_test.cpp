// SPDX-License-Identifier: Apache-2.0
// A session whose exposures were changed while it was taken: the radiometry stays right.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "acquire/sequence.h"
#include "calibrate/calibrate.h"
#include "common/tissue/tissue.h"

namespace dermap {
namespace {

namespace fs = std::filesystem;

// Scene of 50 % gray. The plan saturates 510 nm (ISO 1600), underexposes 450 and 650 nm (ISO 100, where 125
// and 250 would be right) and has no black frame for what becomes of them.
TEST(AdaptedExposure, GrayPatchComesOutWithinHalfAPercent) {
  std::string name = (fs::temp_directory_path() / "dermap-adapted-XXXXXX").string();
  ASSERT_NE(mkdtemp(name.data()), nullptr);
  const fs::path folder = name;
  std::ofstream(folder / "plan.toml")
      << "[[exposure]]\nslot = 1\niso = 100\n[[exposure]]\nslot = 3\niso = 1600\n"
         "[[exposure]]\nslot = 8\niso = 100\n";
  CaptureOptions options;
  options.plan = folder / "plan.toml";
  options.rig = ConfigDirectory() / "rigs/simulated_8band.toml";
  options.scene = ConfigDirectory() / "scenes/gray_50.toml";
  options.out = folder / "session";
  const CaptureSummary summary = RunCapture(options);
  ASSERT_TRUE(summary.session.complete);
  ASSERT_GE(summary.session.exposure_changes.size(), 2u);
  const auto result = CalibrateSession(ReadSession(options.out), {});
  ASSERT_EQ(result.stack.bands.size(), 3u);
  for (std::size_t b = 0; b < result.stack.bands.size(); ++b) {
    double sum = 0.0, count = 0.0;
    const auto& reflectance = result.stack.reflectance[b];
    for (std::size_t i = 0; i < reflectance.size(); ++i) {
      if (result.stack.valid.data()[i] == 0.0f || std::isnan(reflectance.data()[i])) continue;
      sum += reflectance.data()[i];
      count += 1.0;
    }
    EXPECT_GT(count, 50000.0);
    EXPECT_NEAR(sum / count, 0.5, 0.0025) << result.stack.bands[b].wavelength_nm << " nm";
    for (const std::string& note : result.bands[b].notes)
      EXPECT_EQ(note.find("no black frame"), std::string::npos) << note;
  }
  fs::remove_all(folder);
}

}  // namespace
}  // namespace dermap
