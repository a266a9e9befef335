// SPDX-License-Identifier: Apache-2.0
// calibration.json and calibration.csv.
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <sstream>

#include "common/files/atomic_file.h"
#include "studies/calibration_study.h"

namespace dermap {
namespace {

std::string Csv(const CalibrationStudy& study) {
  std::ostringstream out;
  out << "# dermap study calibration --rigs " << study.options.rigs << " --seed " << study.options.seed
      << "; reflectances as fractions, lengths in mm or pixels of the patch\n"
         "rig,seed,flash_drift,vignetting,unevenness,tilt_deg,motion_mm,rotation_deg,stretch,exposure,blur_"
         "px,nonlinearity_stated,"
         "stray_light,stray_light_error,stray_light_sigma,leak,leak_error,leak_sigma,"
         "bias,bias_mid_gray,error_once,error_mid_gray_once,chi2_once,chi2_per_dof,chi2_sharp,alignment_"
         "error_px,"
         "window_error_px,dropped_bands,"
         "failed\n";
  int number = 0;
  for (const auto& r : study.rigs) {
    char line[480];
    std::snprintf(line, sizeof line,
                  "%d,%llu,%.4f,%.3f,%.3f,%.2f,%.3f,%.2f,%.4f,%.3f,%.3f,%d,%.5f,%.6f,%.6f,%.5f,%.6f,%.6f,%."
                  "6f,%.6f,%.6f,%.6f,%.4f,%.4f,%.4f,%."
                  "4f,%.4f,%d,%d\n",
                  number++, static_cast<unsigned long long>(r.seed), r.flash_drift, r.vignetting,
                  r.unevenness, r.tilt_deg, r.motion_mm, r.rotation_deg, r.stretch, r.exposure, r.blur_px,
                  r.nonlinearity_stated ? 1 : 0, r.stray_light, r.stray_light_error, r.stray_light_sigma,
                  r.leak, r.leak_error, r.leak_sigma, r.bias, r.bias_mid_gray, r.error_once,
                  r.error_mid_gray_once, r.chi2_once, r.chi2_per_dof, r.chi2_sharp, r.alignment_error_px,
                  r.window_error_px, r.dropped_bands, r.failure.empty() ? 0 : 1);
    out << line;
  }
  return out.str();
}

}  // namespace

void WriteCalibrationStudy(const std::filesystem::path& folder, const CalibrationStudy& study) {
  const auto entry = [](const MedianAndWorst& m) {
    return nlohmann::json{{"median", m.median}, {"worst", m.worst}};
  };
  nlohmann::json json{{"rigs", study.options.rigs},
                      {"seed", study.options.seed},
                      {"failures", study.failures},
                      {"within_chi2", study.within_chi2},
                      {"within_alignment", study.within_alignment},
                      {"holds", study.Holds()},
                      {"stray_light_error", entry(study.stray_light_error)},
                      {"leak_error", entry(study.leak_error)},
                      {"bias", entry(study.bias)},
                      {"bias_mid_gray", entry(study.bias_mid_gray)},
                      {"error_once", entry(study.error_once)},
                      {"error_mid_gray_once", entry(study.error_mid_gray_once)},
                      {"chi2_once", entry(study.chi2_once)},
                      {"chi2_per_dof", entry(study.chi2_per_dof)},
                      {"chi2_sharp", entry(study.chi2_sharp)},
                      {"alignment_error_px", entry(study.alignment_error_px)},
                      {"window_error_px", entry(study.window_error_px)},
                      {"dropped_bands", entry(study.dropped_bands)},
                      {"limits",
                       {{"bias", kBiasLimit},
                        {"bias_mid_gray", kMidGrayLimit},
                        {"chi2_per_dof", {kChi2Low, kChi2High}},
                        {"alignment_error_px", kAlignmentLimit_px}}}};
  for (const auto& rig : study.rigs) {
    if (!rig.failure.empty()) json["errors"].push_back(rig.failure);
  }
  json["chi2_once"]["mean"] = study.chi2_once_mean;
  FileBatch files;
  WriteFileAtomically(folder / "calibration.csv", Csv(study));
  WriteFileAtomically(folder / "calibration.json", json.dump(2) + "\n");
  files.Commit();
}

}  // namespace dermap
