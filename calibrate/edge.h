// SPDX-License-Identifier: Apache-2.0
// A side of the window, and coordinates along and across it.
#pragma once

#include "calibrate/homography.h"

namespace dermap {

struct Edge {
  Point from, to;
  double length() const;
  Point along() const;  // unit vectors
  // Corners run clockwise in the picture (y down), so the inside lies to the right of the direction of
  // travel.
  Point inwards() const;
  Point At(double t, double s) const;  // t along, s inwards, photosites
};

inline constexpr double kCornerShare =
    0.1;  // of an edge at either end that is not used: corners are cut round

}  // namespace dermap
