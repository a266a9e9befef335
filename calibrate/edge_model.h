// SPDX-License-Identifier: Apache-2.0
// The exact place of one edge of the window, by fitting a model of a blurred edge to the photosites themselves.
#pragma once

#include <optional>

#include "calibrate/homography.h"
#include "calibrate/mosaic.h"

namespace dermap {

struct Edge {
  Point from, to;
  double depth_px = 0.0;  // how far the window reaches inwards from here
  double length() const;
  Point along() const;  // unit vectors
  // Corners run clockwise in the picture (y down), so the inside lies to the right of the direction of travel.
  Point inwards() const;
  Point At(double t, double s) const;  // t along, s inwards, photosites
};

inline constexpr double kCornerShare = 0.1;  // of an edge at either end that is not used: corners are cut round

struct EdgeShift {
  double from_px = 0.0;  // how far the edge lies inwards of where it was thought to be, at either end
  double to_px = 0.0;
  double blur_px = 0.0;         // standard deviation of the blur, photosite's area included
  double uncertainty_px = 0.0;  // one standard deviation of the shift in the middle
};

// At the distance d inwards of the edge a photosite shows, before the lens blurs it,
//   d < 0: tape;   d > 0: T F(d),  F(d) = (1 + q_0 + sum_i q_i erf(d / s_i)) / 2,  q >= 0, sum q = 1.
// A scattering material lit up to the tape's edge reflects half as much right at the edge as far inside, since the light
// of one half plane is missing, and the other half comes back over the range of its scattering [D08 6.1, footnote 1]:
// a mixture of ranges s_i; q_0 is the share that does not spread (a printed target's is 1). Without this, an edge on skin
// is found up to a photosite too far inside.
//
// The photosites are fitted as they are. Interpolating first would not do: where a filter's light reaches one colour only,
// its lattice steps by two photosites, wider than the lens blurs, and half-level points are off by half a photosite.
//
// Levels of tape and skin are free every few photosites along the edge; its two ends, blur and q are common.
// nullopt where the fit fails or wanders off.
std::optional<EdgeShift> FitEdgeModel(const Mosaic& mosaic, const Edge& edge);

}  // namespace dermap
