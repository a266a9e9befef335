// SPDX-License-Identifier: Apache-2.0
// From photosites to the patch: bilinear to twice the patch's size, then a 2x2 box filter [D08 7.2], with the
// noise carried along exactly.
#pragma once

#include <span>
#include <vector>

#include "calibrate/mosaic.h"
#include "calibrate/noise_model.h"
#include "calibrate/patch_map.h"

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

// What a sample reads of one photosite, side by side in memory.
struct PhotositeSignal {
  float skin;        // DN above black
  float spectralon;  // the same
  float smooth;      // Spectralon's, smoothed
  float weight;      // 1 / variance of its reflectance alone, 0 where too weak or masked
};

// Variances of each photosite from smoothed signals, in DN^2 of skin and Spectralon.
struct PhotositeNoise {
  Plane<PhotositeSignal> signals;
  PlaneF skin_variance;  // of the skin frame and its own black
  PlaneF
      spectralon_variance;  // of the Spectralon frame, its own and the shared black, as seen in reflectance
};
PhotositeNoise NoiseOfPhotosites(const Mosaic& mosaic, const MosaicNoise& noise);

// One skin frame of a band, and where the patch lies in it.
struct PatchSource {
  const Mosaic* mosaic;
  PatchMap map;
  const PhotositeNoise* noise;
};

struct ResampledPatch {
  PlaneF reflectance;  // NaN where no usable photosite
  PlaneF sigma;
};

// Mean of a band's skin frames on the patch, the unit square of each map. The four lattices of the pattern
// are interpolated each for itself and combined by inverse variance. Where the window spans more than twice
// the patch's size in photosites, more samples a pixel are taken, so that no photosite is left out. The noise
// of repeated skin frames averages out; that of the one Spectralon frame which they share does so only as far
// as the subject moved over its photosites between the repeats.
// `draft`: two samples a pixel at most, quick: for finding the alignment.
ResampledPatch ResamplePatch(std::span<const PatchSource> sources, int patch_px, bool draft = false);

// Correlation of the noise of pixels (dx, dy) apart, mean over a grid of places, reckoned from the weights.
struct NoiseCorrelation {
  static constexpr int kReach = 3;
  std::vector<double> along_x;  // lag 0 ... kReach, the first is 1
  std::vector<double> along_y;
  double diagonal = 0.0;  // lag (1, 1)
};
NoiseCorrelation CorrelationOfNoise(const PatchSource& source, int patch_px);

// Standard deviation of what one pixel averages over, pixels of the patch: the lens's blur (photosites), the
// interpolation between photosites and the pixel's own samples; mean over a grid of places.
Point BlurOfPatch(const PatchSource& source, double lens_blur_px, int patch_px);

}  // namespace dermap
