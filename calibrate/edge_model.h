// SPDX-License-Identifier: Apache-2.0
// The exact place of one edge of the window, by fitting a model of a blurred edge to the photosites
// themselves.
#pragma once

#include <optional>

#include "calibrate/homography.h"
#include "calibrate/mosaic.h"

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

struct EdgeShift {
  double from_px = 0.0;  // how far the edge lies inwards of where it was thought to be, at either end
  double to_px = 0.0;
  double blur_px = 0.0;         // standard deviation of the blur, photosite's area included
  double uncertainty_px = 0.0;  // one standard deviation of the shift in the middle
};

// Near the edge a photosite at the distance d inwards of it shows
//   outside (1 - E) + (inside + a d + b t) E,  E = (1 + erf(d / (sqrt(2) blur))) / 2,
// with levels of their own every few photosites along the edge; the edge's two ends and the blur are common.
// Interpolating first would not do: where a filter's light reaches one colour only, its lattice steps by two
// photosites, wider than the lens blurs, and half-level points are off by up to half a photosite. nullopt
// where the fit fails or wanders off.
std::optional<EdgeShift> FitEdgeModel(const Mosaic& mosaic, const Edge& edge);

}  // namespace dermap
