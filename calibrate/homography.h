// SPDX-License-Identifier: Apache-2.0
// Projective maps of the plane: camera_from_patch and its like. Points in photosites or in patch units.
#pragma once

#include <array>

namespace dermap {

struct Point {
  double x = 0.0;
  double y = 0.0;
};

struct Homography {
  std::array<double, 9> m{1, 0, 0, 0, 1, 0, 0, 0, 1};  // row by row
  Point operator()(Point p) const {
    const double w = m[6] * p.x + m[7] * p.y + m[8];
    return {(m[0] * p.x + m[1] * p.y + m[2]) / w, (m[3] * p.x + m[4] * p.y + m[5]) / w};
  }
  Homography After(const Homography& first) const;  // this(first(p))
  Homography Inverse() const;
};

// The map from the unit square, (0, 0) at corners[0] and (1, 0) at corners[1], onto four corners.
Homography CameraFromUnit(const std::array<Point, 4>& corners);

// Rotation by `angle_rad` about the middle of the unit square, then a shift (both in units of its side).
Homography UnitMotion(double dx, double dy, double angle_rad);

}  // namespace dermap
