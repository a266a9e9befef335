// SPDX-License-Identifier: Apache-2.0
// dermap calibrate SESSION -o STACK.exr: raw frames to an aligned reflectance stack with its noise.
#include <cstdio>
#include <nlohmann/json.hpp>

#include "apps/command_line.h"
#include "apps/commands.h"
#include "calibrate/calibrate.h"
#include "calibrate/write_calibration.h"
#include "common/files/atomic_file.h"

namespace dermap {
namespace {

Outcome Summarize(const CalibrationResult& result, const std::string& stack_path) {
  Outcome outcome;
  for (const BandCalibration& band : result.bands) {
    char line[200];
    std::snprintf(line, sizeof line, "%6.1f nm  reflectance %.4f  noise %.4f  %s\n", band.band.wavelength_nm,
                  band.median_reflectance, band.median_noise, band.dropped ? "DROPPED" : "");
    outcome.text += line;
    for (const std::string& note : band.notes) outcome.text += "           " + note + "\n";
    if (band.dropped) outcome.code = ExitCode::kGoalNotReached;
  }
  for (const std::string& note : result.notes) outcome.text += note + "\n";
  outcome.text += stack_path + "\n";
  outcome.fill_json = [result, stack_path](nlohmann::json& json) {
    json = {{"stack", stack_path}, {"notes", result.notes}, {"bands", nlohmann::json::array()}};
    for (const BandCalibration& band : result.bands) {
      json["bands"].push_back({{"wavelength_nm", band.band.wavelength_nm},
                               {"median_reflectance", band.median_reflectance},
                               {"median_noise", band.median_noise},
                               {"dropped", band.dropped},
                               {"notes", band.notes}});
    }
  };
  return outcome;
}

}  // namespace

int RunCalibrateCommand(int argc, char** argv) {
  CommandLine command("calibrate",
                      "Turn a session's raw frames into an aligned reflectance stack with its noise.");
  std::filesystem::path session_dir;
  std::filesystem::path stack_path;
  CalibrationOptions options;
  bool no_align = false;
  bool no_verify = false;
  command.app().add_option("SESSION", session_dir, "The session folder")->required();
  command.app().add_option("-o,--output", stack_path, "STACK.exr, or STACK.hdr for ENVI")->required();
  command.app()
      .add_option("--size", options.patch_px, "Pixels along a side of the patch (default 256)")
      ->check(CLI::Range(16, 2048));
  command.app()
      .add_option("--edge-mask-px", options.edge_mask_px,
                  "Pixels along the tape that are marked invalid (default 5)")
      ->check(CLI::Range(0.0, 64.0));
  command.app()
      .add_option("--spectralon-factor", options.spectralon_factor,
                  "Factor on the certificate's reflectance, for polarized light (default 1)")
      ->check(CLI::Range(0.5, 2.0));
  command.app().add_flag("--no-align", no_align, "Align bands by the window alone");
  command.app().add_flag("--no-verify", no_verify, "Do not check the frames' SHA-256 first");
  return command.Run(argc, argv, [&] {
    options.align = !no_align;
    options.verify_hashes = !no_verify;
    ProgressBar bar("calibrate");
    const CalibrationResult result = CalibrateSession(ReadSession(session_dir), options, bar.Function());
    FileBatch files;  // stack, record and pictures, or nothing
    WriteCalibration(stack_path, result);
    files.Commit();
    return Summarize(result, stack_path.string());
  });
}

}  // namespace dermap
