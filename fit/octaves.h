// SPDX-License-Identifier: Apache-2.0
// Planes taken apart into octaves of detail: halved by means of 2 x 2 pixels, doubled by linear
// interpolation.
#pragma once

#include <vector>

#include "common/core/image.h"

namespace dermap {

struct GridShape {
  int width, height;
  std::size_t size() const { return static_cast<std::size_t>(width) * height; }
};

// From the grid itself, halved (rounding up) again and again, to one pixel.
std::vector<GridShape> OctaveShapes(int width, int height);

// Means of 2 x 2 pixels, of 2 or 1 at a border of odd length.
PlaneF Halve(const PlaneF& fine);
// Sums instead of means.
PlaneF HalveSum(const PlaneF& fine);
// Linear between the centres of coarse pixels, constant beyond the outer ones.
PlaneF Interpolate(const PlaneF& coarse, GridShape fine);
// The plane of that kind whose means are `coarse`: Halve(Double(coarse, fine)) = coarse. So detail is what
// halving loses and nothing else.
PlaneF Double(const PlaneF& means, GridShape fine);
// What halving loses: plane - Double(Halve(plane)).
PlaneF DetailOf(const PlaneF& plane);

// The transposes of the above, as linear maps: dot(Halve(x), y) = dot(x, HalveTransposed(y)).
PlaneF HalveTransposed(const PlaneF& coarse, GridShape fine);
PlaneF DoubleTransposed(const PlaneF& fine);
PlaneF DetailTransposed(const PlaneF& plane);

}  // namespace dermap
