// SPDX-License-Identifier: Apache-2.0
// What the report takes from STACK.calibration.json, the record that `calibrate` leaves beside a stack.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace dermap {

struct CalibrationStep {
  std::string step;
  std::string change;  // of the reflectance, with its standard deviation; or why it was not done
};

struct CalibratedBand {  // as text for people; empty where the record says nothing
  std::string wavelength_nm, frame, gray_card_drift, alignment_shift_px, median_noise, saturated_share, notes;
  std::string systematic_sigma;
  std::vector<CalibrationStep> steps;
};

struct CalibrationPicture {
  std::string title;
  std::string data_uri;  // empty where the file could not be read; then `problem` says why
  std::string problem;
};

struct CalibrationRecord {
  std::string session;
  std::string correlation;  // of neighbouring pixels' noise
  std::string notes;
  std::vector<CalibratedBand> bands;
  std::vector<CalibrationPicture> pictures;
  std::string problem;  // why there is nothing above, for the page
};

// Never throws for what the file holds: a report must not fail on a sidecar.
CalibrationRecord ReadCalibrationRecord(const std::filesystem::path& path);

// "data:image/..." of a PNG or JPEG file; throws InputError.
std::string PictureDataUri(const std::filesystem::path& path);

}  // namespace dermap
