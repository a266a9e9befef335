// SPDX-License-Identifier: Apache-2.0
// A recorded session to an aligned stack of reflectance with its noise: the whole of this stage.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "calibrate/alignment.h"
#include "calibrate/frames.h"
#include "calibrate/resample.h"
#include "calibrate/window.h"
#include "common/core/progress.h"
#include "common/files/session.h"
#include "common/files/stack.h"

namespace dermap {

struct CalibrationOptions {
  int patch_px = 256;  // [D08 7.2]
  // Patch pixels along the border that are not valid: blurred with the tape, and skin's window is found a
  // little small (see README).
  double edge_mask_px = 5.0;
  bool align = true;  // by what the bands share inside the window
  AlignmentOptions alignment;
  bool verify_hashes = true;  // every frame against its SHA-256 before anything else
  // What the certificate's value is multiplied by: Spectralon behind crossed polarizers returns another share
  // than its certificate says, by up to 5 % [D08 6.4]. Measured for a rig, or 1.
  double spectralon_factor = 1.0;
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
  bool dropped = false;
  std::vector<std::string> notes;
  PlaneF picture;              // the first skin frame, reduced, 0 ... 1
  double picture_scale = 1.0;  // picture pixels a photosite
};

struct CalibrationResult {
  std::string session;
  ReflectanceStack stack;              // without the dropped bands
  std::vector<BandCalibration> bands;  // ascending wavelength, the dropped ones too
  std::map<int, NoiseModel> noise;     // by ISO
  NoiseCorrelation correlation;        // mean of the bands in the stack
  double hot_share = 0.0;
  double edge_mask_px = 0.0;
  std::vector<std::string> notes;
};

// Throws InputError naming the frame or band: no black or Spectralon frames, a damaged frame, a flash that
// did not fire, no window or two, fewer than one band left.
CalibrationResult CalibrateSession(const Session& session, const CalibrationOptions& options,
                                   const ProgressFunction& progress = {});
// The same with frames from elsewhere than the session's folder. `read` is called from several threads.
CalibrationResult CalibrateFrames(const Session& session, const FrameReader& read,
                                  const CalibrationOptions& options, const ProgressFunction& progress = {});

}  // namespace dermap
