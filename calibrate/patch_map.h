// SPDX-License-Identifier: Apache-2.0
// From the patch to the photosites: the smooth motion of skin within the window, the window's perspective,
// the lens's distortion.
#pragma once

#include <array>

#include "calibrate/homography.h"

namespace dermap {

// A smooth displacement of the patch, in patch pixels, over the unit square: six affine modes and three
// bulges that leave the border alone, for x and for y.
struct Warp {
  static constexpr int kModes = 6;     // 1, u, v (-1 ... 1), three bulges
  std::array<double, 2 * kModes> p{};  // x's modes, then y's; each is its largest shift, about, in pixels
  static std::array<double, kModes> Modes(Point unit);
  Point Of(const std::array<double, kModes>& modes) const;  // displacement, patch pixels
  Point At(Point unit) const { return Of(Modes(unit)); }
};

// A lens that shows a point at the radius r (of the frame's half diagonal) at r (1 + k1 r^2 + k2 r^4). Points
// without distortion are called ideal; windows and homographies live among them.
struct Lens {
  double center_x = 0.0, center_y = 0.0, half_diagonal = 1.0;  // photosites
  double k1 = 0.0, k2 = 0.0;
  Point PhotositesFromIdeal(Point p) const;
  Point IdealFromPhotosites(Point p) const;
};

struct PatchMap {
  Homography camera_from_unit;
  Warp warp;
  double patch_px = 256.0;
  Point operator()(Point unit) const {  // ideal camera coordinates
    const Point d = warp.At(unit);
    return camera_from_unit({unit.x + d.x / patch_px, unit.y + d.y / patch_px});
  }
};

}  // namespace dermap
