// SPDX-License-Identifier: Apache-2.0
// Alignment of the bands with one another by what they share inside the window [D08 6.2]; the window itself,
// found in each frame, has done most of it already.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "common/core/image.h"

namespace dermap {

struct AlignmentOptions {
  double largest_shift_px = 3.0;  // of the patch; more than that is not skin that moved under the tape
  double largest_uncertainty_px =
      0.1;  // one standard deviation: worse than the window's own accuracy is no help
  double smallest_correlation = 0.3;
  int border_px = 16;  // left out: the tape's edges are a structure of the light, not of the skin
};

// A point x of the aligned patch lies at Rotate(x) + shift of the band, in pixels, rotation about the patch's
// middle.
struct BandAlignment {
  double dx_px = 0.0;
  double dy_px = 0.0;
  double angle_rad = 0.0;
  double correlation = 0.0;     // with the mean of the other bands
  double uncertainty_px = 0.0;  // one standard deviation of the shift, estimated
  bool applied = false;
  bool clearly_off = false;  // a sure shift beyond the limit: this band shows something else
  std::string note;          // why not applied; else empty
};

// One band a plane, all of one shape, NaN where missing; `noise`: one standard deviation, one plane a band.
std::vector<BandAlignment> AlignBands(std::span<const PlaneF> reflectance, std::span<const PlaneF> noise,
                                      const AlignmentOptions& options);

}  // namespace dermap
