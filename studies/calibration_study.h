// SPDX-License-Identifier: Apache-2.0
// How right the calibration is: random rigs on the simulated optical bench, whose truth is known.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "common/core/progress.h"
#include "studies/calibration_rig.h"

namespace dermap {

struct CalibrationStudyOptions {
  int rigs = 50;
  std::uint64_t seed = 1;
};

inline constexpr double kBiasLimit = 0.002;
inline constexpr double kMidGrayLimit = 0.001;
inline constexpr double kChi2Low = 0.9;
inline constexpr double kChi2High = 1.1;
inline constexpr double kAlignmentLimit_px = 0.1;

struct MedianAndWorst {
  double median = 0, worst = 0;
};

struct CalibrationStudy {
  CalibrationStudyOptions options;
  std::vector<CalibrationStudyRig> rigs;
  MedianAndWorst stray_light_error, leak_error;  // of what the rigs have measured, shares
  MedianAndWorst bias, bias_mid_gray, error_once, error_mid_gray_once, chi2_once, chi2_per_dof, chi2_sharp,
      alignment_error_px, window_error_px, dropped_bands;
  double chi2_once_mean = 0;  // over all rigs: a rig has but six draws of the gray card
  int failures = 0;
  int resumed = 0;                            // rigs taken over from an earlier run
  int within_chi2 = 0, within_alignment = 0;  // rigs within the limits
  bool Holds() const;                         // within the limits that the calibration is held to
};

// A run into a folder with a journal of the same seed goes on where it was.
CalibrationStudy RunCalibrationStudy(const std::filesystem::path& folder,
                                     const CalibrationStudyOptions& options,
                                     const ProgressFunction& progress);

// calibration.json and calibration.csv, a line a rig; together or not at all.
void WriteCalibrationStudy(const std::filesystem::path& folder, const CalibrationStudy& study);

}  // namespace dermap
