// SPDX-License-Identifier: Apache-2.0
// The square window in the black tape: where it lies in a frame, to a fraction of a photosite [D08 6.1, 6.2].
#pragma once

#include <array>
#include <string>

#include "calibrate/gray_card.h"
#include "calibrate/homography.h"
#include "calibrate/mosaic.h"

namespace dermap {

struct Window {
  std::array<Point, 4> corners;      // camera coordinates, clockwise in the picture from its upper left
  double edge_uncertainty_px = 0.0;  // one standard deviation of an edge's place, estimated, mean of the four
  double blur_px =
      0.0;  // standard deviation of the lens's blur and the photosite's area; 0 where the model failed
  double smallest_side_px = 0.0;
  double largest_side_px = 0.0;
  Homography camera_from_unit;  // the window is the unit square
};

// Finds the one bright quadrilateral on dark tape. The gray card, which divides to a bright patch as well, is
// left out. Throws InputError naming `frame_name` where there is none, or more than one.
Window FindWindow(const Mosaic& mosaic, const PixelRegion& gray_card, double window_mm,
                  const std::string& frame_name);

// Moves the four edges to where the model of edge_model.h has them. Throws as above.
Window RefineWindow(const Mosaic& mosaic, const std::array<Point, 4>& rough, double window_mm,
                    const std::string& frame_name);

}  // namespace dermap
