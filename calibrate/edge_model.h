// SPDX-License-Identifier: Apache-2.0
// The exact place of the window's four edges, by fitting a model of a blurred edge of lit skin to the
// photosites themselves.
#pragma once

#include <array>
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
  double blur_px = 0.0;         // standard deviation of the blur, photosite's area included; of all edges
  double uncertainty_px = 0.0;  // one standard deviation of the shift in the middle
};

// Near an edge a photosite at the distance d inwards of it shows, blurred by the lens, `outside` for d < 0
// and for d > 0
//   inside (1 - sum_k w_k exp(-d / l_k) / 2) + across d + along u:
// light that skin scatters sideways out of the lit half-plane is lost under the tape. The exact optics of the
// layers give a loss of exp(-(d / l)^p) / 2, p = 0.68 +- 0.03, l depending on the band; such a function (any
// p below 1) is a mixture of exponentials, of which two of fixed lengths and free shares do. Gaussians do
// not: they are flat at the edge, where the loss is steepest. A free length would go to 0 on a target that
// loses nothing, and leave the edge's place open. The shares w_k and the blur are common to the four edges,
// the other levels to a stretch of
// an edge. On a target without lateral transport the w_k come out as 0. Interpolating first would not do:
// where a filter's light reaches one colour only, its lattice steps by two photosites, wider than the lens
// blurs, and half-level points are off by up to half a photosite. nullopt where the fit fails or wanders off.
std::optional<std::array<EdgeShift, 4>> FitEdges(const Mosaic& mosaic, const std::array<Edge, 4>& edges,
                                                 double window_mm);

}  // namespace dermap
