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
#include "calibrate/measure_stray_light.h"
#include "calibrate/polarization.h"
#include "calibrate/raw_frame.h"
#include "calibrate/session_sheet.h"
#include "calibrate/target_frames.h"
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

[[noreturn]] void FailWithPicture(const std::filesystem::path& output, const std::string& message,
                                  const Plane<Rgb8>& picture) {
  const auto path = Beside(output, ".failure.png");
  WritePng(path, picture);
  throw InputError(message + " (see " + path.string() + ")");
}

// A frame that cannot be used leaves its picture, OUTPUT.failure.png, one that is not there a picture of the
// session as it was found; and nothing else.
template <class Work>
auto OrShow(const std::filesystem::path& output, const Session& session, const Work& work) {
  try {
    return work();
  } catch (const CaptureFailure& failure) {
    FailWithPicture(output, failure.what(), failure.picture());
  } catch (const InputError& error) {
    const SessionSheet sheet = DrawSessionSheet(session);
    if (sheet.bad == 0) throw;
    FailWithPicture(output, error.what(), sheet.picture);
  }
}

Session ReadAnySession(const std::filesystem::path& session_dir, const std::filesystem::path& files_toml,
                       const std::filesystem::path& output) {
  if (files_toml.empty()) return ReadSession(session_dir);
  try {
    return ReadFolderSession(files_toml);
  } catch (const UnreadableFrame& failure) {
    FailWithPicture(output, failure.what(), DrawSessionSheet(failure.session()).picture);
  }
}

FrameReader ReaderOf(const Session& session) {
  return [&session](const FrameRecord& record) { return ReadBayerFrame(session.directory / record.file); };
}

Outcome WritePolarization(const Session& session, const std::filesystem::path& toml_path) {
  const PolarizationMeasurement found =
      OrShow(toml_path, session, [&] { return MeasurePolarization(session, ReaderOf(session)); });
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

Outcome WriteStrayLight(const Session& session, const std::optional<Known>& dark_target,
                        const std::filesystem::path& toml_path) {
  const StrayLightMeasurement found =
      OrShow(toml_path, session, [&] { return MeasureStrayLight(session, ReaderOf(session), dark_target); });
  WriteFileAtomically(toml_path, StrayLightToml(found));
  Outcome outcome;
  char line[200];
  for (const StrayLightBand& band : found.bands) {
    std::snprintf(line, sizeof line, "%6.1f nm  stray light %.5f +- %.5f  tape %.4f%s\n", band.wavelength_nm,
                  band.share.value, band.share.sigma, band.tape,
                  band.leak ? ("  leak " + FormatValue(band.leak->value)).c_str() : "");
    outcome.text += line;
  }
  std::snprintf(line, sizeof line, "stray light %.5f +- %.5f\n", found.share.value, found.share.sigma);
  outcome.text += line;
  if (found.leak) {
    std::snprintf(line, sizeof line, "leak %.5f +- %.5f\n", found.leak->value, found.leak->sigma);
    outcome.text += line;
  }
  outcome.text += toml_path.string() + "\n";
  outcome.fill_json = [found, toml_path](nlohmann::json& json) {
    json = {{"toml", toml_path.string()},
            {"stray_light", found.share.value},
            {"stray_light_sigma", found.share.sigma},
            {"bands", nlohmann::json::array()}};
    if (found.leak) {
      json["leak"] = found.leak->value;
      json["leak_sigma"] = found.leak->sigma;
    }
    for (const StrayLightBand& b : found.bands) {
      json["bands"].push_back({{"wavelength_nm", b.wavelength_nm},
                               {"stray_light", b.share.value},
                               {"stray_light_sigma", b.share.sigma},
                               {"tape_reflectance", b.tape}});
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
  bool stray_light = false;
  std::filesystem::path dark_dir;
  Known dark_target{0.0, 0.001};
  auto* session_option = command.app().add_option("SESSION", session_dir, "The session folder");
  command.app()
      .add_option("--from-folder", files_toml,
                  "FILES.toml in place of SESSION: raw files without our manifest")
      ->excludes(session_option);
  command.app().add_flag("--polarization", polarization,
                         "Measure the polarizer's amplitudes from s and p frames; -o names a TOML file");
  auto* stray_option = command.app().add_flag("--stray-light", stray_light,
                                              "Measure the lens's stray light from a white and a black "
                                              "target behind the window in the tape; -o names a "
                                              "TOML file");
  command.app()
      .add_option("--dark-target", dark_dir, "With --stray-light: another session, of the black target")
      ->needs(stray_option);
  auto* dark_option =
      command.app()
          .add_option("--dark-reflectance", dark_target.value,
                      "With --stray-light: what the black target reflects from below its surface; tells the "
                      "polarizers' leak")
          ->check(Within(0.0, 0.1))
          ->needs(stray_option);
  command.app()
      .add_option("--dark-reflectance-sigma", dark_target.sigma, "How well that is known (default 0.001)")
      ->check(Within(0.0, 0.1))
      ->needs(dark_option);
  command.app().add_option("-o,--output", stack_path, "STACK.exr, or STACK.hdr for ENVI")->required();
  command.app()
      .add_option("--size", options.patch_px, "Pixels along a side of the patch (default 256)")
      ->check(Within(16, 2048));
  command.app()
      .add_option("--edge-mask-px", options.edge_mask_px,
                  "Pixels along the tape that are marked invalid (default 5)")
      ->check(Within(0.0, 64.0));
  command.app()
      .add_option("--spectralon-factor", options.spectralon_factor,
                  "Factor on the certificate's reflectance, for polarized light (default 1)")
      ->check(Within(0.5, 2.0));
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
    const Session session = ReadAnySession(session_dir, files_toml, stack_path);
    if (foreign) options.verify_hashes = false;  // nobody wrote any down
    if (polarization && stray_light)
      throw InputError("--polarization and --stray-light are two measurements; expected one of them");
    if (polarization || stray_light) {
      const Session measured = dark_dir.empty() ? session : JoinSessions(session, ReadSession(dark_dir));
      if (options.verify_hashes) OrShow(stack_path, measured, [&] { VerifyFrames(measured); });
      if (polarization) return WritePolarization(measured, stack_path);
      return WriteStrayLight(measured, dark_option->count() > 0 ? std::optional(dark_target) : std::nullopt,
                             stack_path);
    }
    ProgressBar bar("calibrate");
    const CalibrationResult result =
        OrShow(stack_path, session, [&] { return CalibrateSession(session, options, bar.Function()); });
    FileBatch files;  // stack, record and pictures, or nothing
    WriteCalibration(stack_path, result);
    if (LacksFrames(session)) WritePng(Beside(stack_path, ".missing.png"), DrawSessionSheet(session).picture);
    if (check) WritePng(Beside(stack_path, ".check.png"), CheckPicture(result));
    files.Commit();
    return Summarize(result, stack_path.string());
  });
}

}  // namespace dermap
