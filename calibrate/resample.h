// SPDX-License-Identifier: Apache-2.0
// From photosites to the patch: bilinear to twice the patch's size, then a 2x2 box filter [D08 7.2], with the
// noise carried along exactly.
#pragma once

#include <vector>

#include "calibrate/homography.h"
#include "calibrate/mosaic.h"
#include "calibrate/noise_model.h"

namespace dermap {

// How the noise of a mosaic's photosites came about.
struct MosaicNoise {
  NoiseModel skin;
  NoiseModel spectralon;
  int spectralon_frames = 1;  // averaged
  // Variance of what both frames share by the same black frame, in reads of one frame: 1 / number of black
  // frames; 0 where two different black frames were subtracted.
  double shared_black = 0.0;
  double skin_black = 0.0;  // own black frames: 1 / number, where not shared
  double spectralon_black = 0.0;
};

struct ResampledPatch {
  PlaneF reflectance;          // NaN where no usable photosite
  PlaneF skin_variance;        // of the skin frame's noise
  PlaneF spectralon_variance;  // of the Spectralon frame's (shared by repeats)
};

// camera_from_unit: the patch is the unit square. The four lattices of the pattern are interpolated each for
// itself and combined by inverse variance. Where the window spans more than twice the patch's size in
// photosites, more samples a pixel are taken, so that no photosite is left out.
ResampledPatch ResamplePatch(const Mosaic& mosaic, const Homography& camera_from_unit,
                             const MosaicNoise& noise, int patch_px);

// Correlation of the noise of pixels (dx, dy) apart, mean over a grid of places, reckoned from the weights.
struct NoiseCorrelation {
  static constexpr int kReach = 3;
  std::vector<double> along_x;  // lag 0 ... kReach, the first is 1
  std::vector<double> along_y;
  double diagonal = 0.0;  // lag (1, 1)
};
NoiseCorrelation CorrelationOfNoise(const Mosaic& mosaic, const Homography& camera_from_unit,
                                    const MosaicNoise& noise, int patch_px);

}  // namespace dermap
