// SPDX-License-Identifier: Apache-2.0
// A recorded session to an aligned stack of reflectance with its noise: the whole of this stage.
#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "calibrate/alignment.h"
#include "calibrate/corrections.h"
#include "calibrate/frames.h"
#include "calibrate/linearity.h"
#include "calibrate/resample.h"
#include "calibrate/window.h"
#include "common/core/progress.h"
#include "common/files/session.h"
#include "common/files/stack.h"

namespace dermap {

struct CalibrationOptions {
  int patch_px = 256;         // [D08 7.2]
  double edge_mask_px = 5.0;  // patch pixels along the border that are not valid: blurred with the tape
  bool align = true;          // by what the bands share inside the window
  AlignmentOptions alignment;
  bool verify_hashes = true;       // every frame against its SHA-256 before anything else
  double spectralon_factor = 1.0;  // what the certificate's value is multiplied by
  StepSet skip;                    // steps that are left out
};

struct BandCalibration {
  Band band;
  std::vector<std::string> skin_files;
  std::vector<std::string> spectralon_files;
  double certified_reflectance = 0.0;
  std::vector<double>
      gray_card_drift;          // flash of each skin frame over that of the Spectralon frame, ISO taken out
  std::vector<Window> windows;  // one a skin frame
  BandAlignment alignment;
  double median_reflectance = 0.0;
  double median_noise = 0.0;     // sigma, reflectance
  double saturated_share = 0.0;  // of the window's photosites
  double masked_share = 0.0;     // saturated, hot or dead
  NoiseCorrelation correlation;
  Point blur_px;                  // what a pixel averages over, one standard deviation, pixels of the patch
  std::vector<StepRecord> steps;  // in the order of their doing
  double systematic_sigma = 0.0;  // all steps together, relative, common to all pixels
  double effective_wavelength_nm =
      0.0;  // of the light as the sensor weighs it; 0 where the rig does not tell
  std::array<double, kLatticeCount>
      spectralon_colours{};  // mean signals, DN; 0 where a lattice holds several
  std::array<char, kLatticeCount> lattice_colours{};
  bool dropped = false;
  std::vector<std::string> notes;
  PlaneF picture;              // the first skin frame, reduced, 0 ... 1
  double picture_scale = 1.0;  // picture pixels a photosite
};

struct StageSeconds {
  std::string stage;
  double seconds = 0.0;
};

struct CalibrationResult {
  std::string session;
  ReflectanceStack stack;              // without the dropped bands
  std::vector<BandCalibration> bands;  // ascending wavelength, the dropped ones too
  std::map<int, NoiseModel> noise;     // by ISO
  NoiseCorrelation correlation;        // mean of the bands in the stack
  Linearity linearity;
  double hot_share = 0.0;
  double pixel_size_sigma_mm = 0.0;
  double edge_mask_px = 0.0;
  std::vector<std::string> notes;
  std::vector<StageSeconds> seconds;  // where the time went
};

// Throws InputError naming the frame or band: no black or Spectralon frames, a damaged frame, a flash that
// did not fire, no window or two, fewer than one band left.
CalibrationResult CalibrateSession(const Session& session, const CalibrationOptions& options,
                                   const ProgressFunction& progress = {});
// The same with frames from elsewhere than the session's folder. `read` is called from several threads.
CalibrationResult CalibrateFrames(const Session& session, const FrameReader& read,
                                  const CalibrationOptions& options, const ProgressFunction& progress = {});

}  // namespace dermap
