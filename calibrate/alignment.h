// SPDX-License-Identifier: Apache-2.0
// Alignment of the bands with one another by what they share inside the window [D08 6.2]; the window itself,
// found in each frame, has done most of it already.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "calibrate/patch_map.h"
#include "common/core/image.h"

namespace dermap {

struct AlignmentOptions {
  double largest_shift_px = 3.0;  // of the patch; more than that is not skin that moved under the tape
  double largest_uncertainty_px =
      0.1;  // one standard deviation: worse than the window's own accuracy is no help
  double smallest_correlation = 0.3;
  int border_px = 16;  // left out: the tape's edges are a structure of the light, not of the skin
};

// A point x of the aligned patch lies at x + warp(x) of the band, in pixels.
struct BandAlignment {
  Warp warp;
  double dx_px = 0.0;  // of the patch's middle
  double dy_px = 0.0;
  double angle_rad = 0.0;
  double stretch_px = 0.0;      // largest shift by what is neither shift nor rotation
  double correlation = 0.0;     // with the mean of the other bands
  double uncertainty_px = 0.0;  // one standard deviation of the shift, estimated
  bool applied = false;
  double found_shift_px = 0.0;  // of the patch's middle, applied or not
  bool clearly_off = false;     // a sure shift beyond the limit: this band shows something else
  std::string note;             // why not applied; else empty
  PlaneF residual;  // structure of the band against the mean of the others, in standard deviations
};

// One band a plane, all of one shape, NaN where missing; `noise`: one standard deviation, one plane a band.
// `window_sigma_px`: how well each band's window is known, one standard deviation of an edge, patch pixels:
// skin is held by the tape, so where the window is known well, shift, strain and rotation are small. Empty:
// not known.
std::vector<BandAlignment> AlignBands(std::span<const PlaneF> reflectance, std::span<const PlaneF> noise,
                                      std::span<const double> window_sigma_px,
                                      const AlignmentOptions& options);

}  // namespace dermap
