// SPDX-License-Identifier: Apache-2.0
// One random rig of the study of the calibration: drawn, captured on the optical bench, calibrated, judged.
#pragma once

#include <cstdint>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace dermap {

// One random rig: what was drawn, and what its calibration came to.
struct CalibrationStudyRig {
  std::uint64_t seed = 0;
  double flash_drift = 0, vignetting = 0, unevenness = 0, tilt_deg = 0, motion_mm = 0, rotation_deg = 0,
         stretch = 0, exposure = 0, blur_px = 0;
  bool nonlinearity_stated = false;  // by the rig; else it is left to the session's own frames
  // Shares of the lens's stray light and of the polarizers' leak; what the rig states of them it has measured
  // on a white and a black target of its own, `error` off, one standard deviation `sigma`.
  double stray_light = 0, stray_light_error = 0, stray_light_sigma = 0;
  double leak = 0, leak_error = 0, leak_sigma = 0;
  // Patches of 0.02 to 0.95 in two bands: largest error of a patch's mean, reflectance. Bias is what the mean
  // of several sessions leaves; a single one has the noise of its patches' photons and of the gray card's as
  // well.
  double bias = 0;
  double bias_mid_gray = 0;                        // the same of the patches of 0.18 and 0.5
  double error_once = 0, error_mid_gray_once = 0;  // largest of the single sessions
  double chi2_once = 0;  // mean square of their errors over what the sessions themselves say of them
  // Skin: mean square of (measured - truth) / sigma over the valid pixels of all bands, the truth as a pixel
  // of the stack averages it (blur_px of the record), where the skin of the bands' shots lay on average; and
  // against the truth itself.
  double chi2_per_dof = 0;
  double chi2_sharp = 0;
  // Root mean square of a band's place against the mean of all bands, worst band, patch pixels.
  double alignment_error_px = 0;
  double window_error_px = 0;  // the same against the truth, mean of the bands
  int dropped_bands = 0;
  std::string failure;  // an error in place of a calibration; else empty
};

nlohmann::json ToJson(const CalibrationStudyRig& rig);
CalibrationStudyRig CalibrationStudyRigFromJson(const nlohmann::json& json);

// What all rigs share: the filters, the patches, and skin rendered once, when it is first asked for.
class CalibrationStage {
 public:
  CalibrationStage();
  ~CalibrationStage();
  // Everything random follows from the study's seed and the rig's number, so any rig can be run alone.
  CalibrationStudyRig Run(std::uint64_t seed, int number);

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace dermap
