// SPDX-License-Identifier: Apache-2.0
// dermap study calibration --rigs N --seed S -o DIR: random rigs on the optical bench, calibrated and judged.
#include <cstdio>
#include <nlohmann/json.hpp>

#include "apps/command_line.h"
#include "apps/commands.h"
#include "studies/calibration_study.h"

namespace dermap {

int RunCalibrationStudyCommand(int argc, char** argv) {
  CommandLine command(
      "study calibration",
      "How right the calibration is, on random rigs of the optical bench. A run that was broken off "
      "goes on where it was.");
  std::filesystem::path folder;
  CalibrationStudyOptions options;
  command.app()
      .add_option("-o,--output", folder, "The folder to write calibration.{json,csv} to")
      ->required();
  command.app().add_option("--rigs", options.rigs, "Random rigs (default 50)")->check(Within(1, 100000));
  command.app().add_option("--seed", options.seed, "Everything random follows from it (default 1)");
  return command.Run(argc, argv, [&] {
    ProgressBar bar("study calibration");
    const CalibrationStudy study = RunCalibrationStudy(folder, options, bar.Function());
    WriteCalibrationStudy(folder, study);
    Outcome outcome;
    outcome.code = study.Holds() ? ExitCode::kSuccess : ExitCode::kGoalNotReached;
    const auto line = [&](const char* name, const MedianAndWorst& m, const char* limit) {
      char text[160];
      std::snprintf(text, sizeof text, "%-20s median %.5f  worst %.5f  (limit %s)\n", name, m.median, m.worst,
                    limit);
      outcome.text += text;
    };
    line("stray_light_error", study.stray_light_error, "none");
    line("leak_error", study.leak_error, "none");
    line("bias", study.bias, "0.002");
    line("bias_mid_gray", study.bias_mid_gray, "0.001");
    line("error_mid_gray_once", study.error_mid_gray_once, "none");
    line("chi2_once", study.chi2_once, "none");
    line("chi2_per_dof", study.chi2_per_dof, "0.9 to 1.1");
    line("chi2_sharp", study.chi2_sharp, "none");
    line("alignment_error_px", study.alignment_error_px, "0.1");
    line("window_error_px", study.window_error_px, "none");
    line("dropped_bands", study.dropped_bands, "none");
    if (study.failures > 0)
      outcome.text += std::to_string(study.failures) + " rigs were not calibrated at all\n";
    outcome.text += "within the limits: chi2 " + std::to_string(study.within_chi2) + ", alignment " +
                    std::to_string(study.within_alignment) + " of " + std::to_string(options.rigs) +
                    " rigs, " + std::to_string(study.resumed) + " of them from an earlier run\n";
    outcome.text += (folder / "calibration.json").string() + "\n";
    const bool holds = study.Holds();
    outcome.fill_json = [folder, holds](nlohmann::json& json) {
      json = {{"study", (folder / "calibration.json").string()}, {"holds", holds}};
    };
    return outcome;
  });
}

}  // namespace dermap
