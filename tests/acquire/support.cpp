// SPDX-License-Identifier: Apache-2.0
// Small rigs, plans and scenes.
#include "tests/acquire/support.h"

#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <stdexcept>

namespace dermap::acquire_test {

TemporaryFolder::TemporaryFolder() {
  std::string name = (std::filesystem::temp_directory_path() / "dermap-acquire-XXXXXX").string();
  if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("no temporary folder");
  path_ = name;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

std::filesystem::path TemporaryFolder::Write(const std::string& name, const std::string& text) const {
  std::ofstream(path_ / name) << text;
  return path_ / name;
}

RigConfig SmallRig() {
  RigConfig rig;
  rig.name = "small";
  rig.slots = {{1, 540.0, 10.0, false}, {2, 650.0, 10.0, false}, {3, 0.0, 0.0, true}};
  return rig;
}

Scene FlatScene(double reflectance, const BenchConfig& bench, std::uint64_t seed) {
  Scene scene;
  scene.name = "flat";
  scene.seed = seed;
  scene.pattern = TestPattern{.kind = TestPattern::Kind::kFlat, .low = reflectance, .high = reflectance};
  scene.bench = bench;
  return scene;
}

std::string SmallRigToml(const std::string& scene) {
  return "name = \"small\"\n[wheel]\n"
         "[[wheel.slot]]\nslot = 1\nwavelength_nm = 540\nfwhm_nm = 10\n"
         "[[wheel.slot]]\nslot = 2\nwavelength_nm = 650\nfwhm_nm = 10\n"
         "[[wheel.slot]]\nslot = 3\nopaque = true\n"
         "[simulated]\nscene = \"" +
         scene + "\"\n";
}

std::string SmallPlanToml() {
  return "[[exposure]]\nslot = 1\nexposure_ms = 10\niso = 100\n"
         "[[exposure]]\nslot = 2\nexposure_ms = 10\niso = 250\n";
}

std::string SmallSceneToml() {
  return "seed = 9\nflat_reflectance = 0.5\n"
         "[bench]\nwidth_px = 96\nheight_px = 72\nscale_px_per_mm = 7\nwindow_center_px = [38, 35.5]\n";
}

std::chrono::steady_clock::time_point WatchedStation::Expose(const CaptureSettings& settings) {
  ++shots[settings.shot];
  if (before_capture) before_capture(settings);
  exposed_ = settings;
  return inner_.camera().Expose(settings);
}

RawFrame WatchedStation::Fetch() {
  RawFrame frame = inner_.camera().Fetch();
  if (after_capture) after_capture(exposed_, frame);
  return frame;
}

}  // namespace dermap::acquire_test
