// SPDX-License-Identifier: Apache-2.0
// dermap calibrate SESSION -o STACK.exr: raw frames to an aligned reflectance stack with its noise.
#include <cstdio>
#include <nlohmann/json.hpp>

#include "apps/command_line.h"
#include "apps/commands.h"
#include "calibrate/calibrate.h"
#include "calibrate/check_picture.h"
#include "calibrate/failure.h"
#include "calibrate/folder_session.h"
#include "calibrate/polarization.h"
#include "calibrate/raw_frame.h"
#include "calibrate/write_calibration.h"
#include "common/files/atomic_file.h"
#include "common/files/picture.h"

namespace dermap {
namespace {

std::filesystem::path Beside(std::filesystem::path output, const std::string& extension) {
  return output.replace_extension(extension);
}

StepSet StepsOf(const std::vector<std::string>& names) {
  StepSet steps;
  for (const std::string& name : names) {
    const auto step = StepFromName(name);
    if (!step) {
      throw InputError("--skip: there is no step '" + name + "'; expected one of " + AllStepNames());
    }
    steps.insert(*step);
  }
  return steps;
}

// A frame that cannot be used leaves its picture, OUTPUT.failure.png, and nothing else.
template <class Work>
auto OrShow(const std::filesystem::path& output, const Work& work) {
  try {
    return work();
  } catch (const CaptureFailure& failure) {
    const auto picture = Beside(output, ".failure.png");
    WritePng(picture, failure.picture());
    throw InputError(std::string(failure.what()) + " (see " + picture.string() + ")");
  }
}

Outcome MeasureAndWrite(const Session& session, bool verify, const std::filesystem::path& toml_path) {
  if (verify) VerifyFrames(session);
  const PolarizationMeasurement found = OrShow(toml_path, [&] {
    return MeasurePolarization(
        session, [&](const FrameRecord& record) { return ReadBayerFrame(session.directory / record.file); });
  });
  WriteFileAtomically(toml_path, PolarizationToml(found));
  Outcome outcome;
  for (const PolarizationBand& band : found.bands) {
    char line[160];
    std::snprintf(line, sizeof line, "%6.1f nm  Spectralon %+.4f +- %.4f  skin %+.4f +- %.4f\n",
                  band.wavelength_nm, band.spectralon.value, band.spectralon.sigma, band.skin.value,
                  band.skin.sigma);
    outcome.text += line;
  }
  outcome.text += toml_path.string() + "\n";
  outcome.fill_json = [found, toml_path](nlohmann::json& json) {
    json = {{"toml", toml_path.string()},
            {"flash_scatter", found.flash_scatter},
            {"bands", nlohmann::json::array()}};
    for (const PolarizationBand& b : found.bands) {
      json["bands"].push_back({{"wavelength_nm", b.wavelength_nm},
                               {"spectralon", b.spectralon.value},
                               {"spectralon_sigma", b.spectralon.sigma},
                               {"skin", b.skin.value},
                               {"skin_sigma", b.skin.sigma}});
    }
  };
  return outcome;
}

Outcome Summarize(const CalibrationResult& result, const std::string& stack_path) {
  Outcome outcome;
  for (const BandCalibration& band : result.bands) {
    char line[200];
    std::snprintf(line, sizeof line, "%6.1f nm  reflectance %.4f  noise %.4f  %s\n", band.band.wavelength_nm,
                  band.median_reflectance, band.median_noise, band.dropped ? "DROPPED" : "");
    outcome.text += line;
    for (const StepRecord& step : band.steps) {
      if (!step.applied || (step.effect == 0.0 && step.sigma == 0.0)) continue;
      std::snprintf(line, sizeof line, "           %-20s %+8.3f %%  +- %.3f %%\n",
                    std::string(NameOf(step.step)).c_str(), 100 * step.effect, 100 * step.sigma);
      outcome.text += line;
    }
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
  std::filesystem::path files_toml;
  std::filesystem::path stack_path;
  CalibrationOptions options;
  bool no_align = false;
  bool no_verify = false;
  bool polarization = false;
  auto* session_option = command.app().add_option("SESSION", session_dir, "The session folder");
  command.app()
      .add_option("--from-folder", files_toml,
                  "FILES.toml in place of SESSION: raw files without our manifest")
      ->excludes(session_option);
  command.app().add_flag("--polarization", polarization,
                         "Measure the polarizer's amplitudes from s and p frames; -o names a TOML file");
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
  std::vector<std::string> skip;
  command.app()
      .add_option("--skip", skip, "Steps to leave out, with commas: " + AllStepNames())
      ->delimiter(',');
  bool check = false;
  command.app().add_flag("--check", check, "Also write STACK.check.png: windows, grids, alignment residuals");
  command.app().add_flag("--no-verify", no_verify, "Do not check the frames' SHA-256 first");
  return command.Run(argc, argv, [&] {
    options.align = !no_align;
    options.verify_hashes = !no_verify;
    options.skip = StepsOf(skip);
    if (options.skip.count(Step::kAlignment) != 0) options.align = false;
    if (session_dir.empty() == files_toml.empty())
      throw InputError("nothing to calibrate; expected a SESSION folder, or --from-folder FILES.toml");
    const bool foreign = !files_toml.empty();
    const Session session = foreign ? ReadFolderSession(files_toml) : ReadSession(session_dir);
    if (foreign) options.verify_hashes = false;  // nobody wrote any down
    if (polarization) return MeasureAndWrite(session, options.verify_hashes, stack_path);
    ProgressBar bar("calibrate");
    const CalibrationResult result =
        OrShow(stack_path, [&] { return CalibrateSession(session, options, bar.Function()); });
    FileBatch files;  // stack, record and pictures, or nothing
    WriteCalibration(stack_path, result);
    if (check) WritePng(Beside(stack_path, ".check.png"), CheckPicture(result));
    files.Commit();
    return Summarize(result, stack_path.string());
  });
}

}  // namespace dermap
