// SPDX-License-Identifier: Apache-2.0
// The camera's view of the plane of the skin: a pinhole, tilted about the horizontal axis (which shortens the
// vertical one).
//
// Bench coordinates: mm in the plane of the skin, origin where the window's centre nominally lies, x right, y
// down. Patch coordinates: mm from the window's top left corner. They differ by where the subject has moved.
// Pixel coordinates: the centre of the first photosite is (0, 0).
#pragma once

#include <array>

#include "acquire/simulated/bench_config.h"

namespace dermap {

struct Point2 {
  double x = 0.0;
  double y = 0.0;
};

// Where the subject is in one shot.
struct Pose {
  double shift_x_mm = 0.0;
  double shift_y_mm = 0.0;
  double rotation_deg = 0.0;  // about the window's centre, clockwise on the image
  double strain_x = 0.0;      // the tape and the skin are stretched by these
  double strain_y = 0.0;
  double bulge_x_mm = 0.0;  // shift of the window's middle against its border
  double bulge_y_mm = 0.0;
};

class PinholeView {
 public:
  PinholeView(const BenchConfig& config, double view_angle_deg);
  Point2 PixelFromBench(Point2 bench_mm) const noexcept;
  Point2 BenchFromPixel(Point2 pixel) const noexcept;

 private:
  double center_x_px_, center_y_px_;
  double focal_px_, distance_mm_, sin_, cos_;
  double frame_x_px_, frame_y_px_, half_diagonal_px_, distortion_k1_;  // the lens's axis: the frame's centre
};

Point2 BenchFromPatch(const Pose& pose, double window_mm, Point2 patch_mm) noexcept;
Point2 PatchFromBench(const Pose& pose, double window_mm, Point2 bench_mm) noexcept;

// Top left, top right, bottom right, bottom left, in pixels.
std::array<Point2, 4> WindowCorners(const PinholeView& view, const Pose& pose, double window_mm) noexcept;

}  // namespace dermap
