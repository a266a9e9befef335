// SPDX-License-Identifier: Apache-2.0
// How right the calibration is: random rigs on the simulated optical bench, whose truth is known.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "common/core/progress.h"

namespace dermap {

struct CalibrationStudyOptions {
  int rigs = 50;
  std::uint64_t seed = 1;
};

// One random rig: what was drawn, and what its calibration came to.
struct CalibrationStudyRig {
  std::uint64_t seed = 0;
  double flash_drift = 0, vignetting = 0, unevenness = 0, tilt_deg = 0, motion_mm = 0, rotation_deg = 0,
         stretch = 0, exposure = 0, blur_px = 0;
  // Patches of 0.02 to 0.95 in two bands: largest error of a patch's mean, reflectance.
  double bias = 0;
  double bias_mid_gray = 0;  // the same of the patches of 0.18 and 0.5
  // Skin: mean square of (measured - truth) / sigma over the valid pixels of all bands, the truth as a pixel
  // of the stack averages it (blur_px of the record); and against the truth itself.
  double chi2_per_dof = 0;
  double chi2_sharp = 0;
  // Root mean square of a band's place against the mean of all bands, worst band, patch pixels.
  double alignment_error_px = 0;
  double window_error_px = 0;  // the same against the truth, mean of the bands
  int dropped_bands = 0;
  std::string failure;  // an error in place of a calibration; else empty
};

struct MedianAndWorst {
  double median = 0, worst = 0;
};

struct CalibrationStudy {
  CalibrationStudyOptions options;
  std::vector<CalibrationStudyRig> rigs;
  MedianAndWorst bias, bias_mid_gray, chi2_per_dof, chi2_sharp, alignment_error_px, window_error_px,
      dropped_bands;
  int failures = 0;
  double seconds = 0;
  bool Holds() const;  // within the limits that the calibration is held to
};

CalibrationStudy RunCalibrationStudy(const CalibrationStudyOptions& options,
                                     const ProgressFunction& progress);

// calibration.json and calibration.csv, a line a rig; together or not at all.
void WriteCalibrationStudy(const std::filesystem::path& folder, const CalibrationStudy& study);

}  // namespace dermap
