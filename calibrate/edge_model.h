// SPDX-License-Identifier: Apache-2.0
// The exact place of the window's four edges, by fitting a model of a blurred edge of lit skin to the
// photosites themselves.
#pragma once

#include <array>
#include <optional>

#include "calibrate/edge.h"
#include "calibrate/mosaic.h"

namespace dermap {

struct EdgeShift {
  double from_px = 0.0;  // how far the edge lies inwards of where it was thought to be, at either end
  double to_px = 0.0;
  double blur_px = 0.0;         // standard deviation of the blur, photosite's area included; of all edges
  double uncertainty_px = 0.0;  // one standard deviation of the shift in the middle
};

// Near an edge a photosite at the distance d inwards of it shows, blurred by the lens, `outside` for d < 0
// and for d > 0
//   inside (1 - w L(d / l) / 2) + across d + along u:
// light that skin scatters sideways out of the lit half-plane is lost under the tape. By the exact optics of
// the layers L(x) is exp(-x^p), p = 0.66 +- 0.05, with a length l of the band's own, 0.03 to 0.3 mm. Right at
// the edge, by symmetry, half of the light that spreads is lost: w is 1, nearly; or 0, on a target without
// lateral transport. Both are fitted, and the one that explains the photosites is taken: with a free share
// the shortest lengths would pass for a shift of the edge. w, l and the blur are common to the four edges,
// the other levels to a stretch of an edge. Interpolating first would not do: where a filter's light reaches
// one colour only, its lattice steps by two photosites, wider than the lens blurs, and half-level points are
// off by up to half a photosite. nullopt where the fit fails or wanders off.
// Of a large window no more than `most_samples` photosites are used, evenly spread.
inline constexpr std::size_t kEdgeSamples = 20000;
std::optional<std::array<EdgeShift, 4>> FitEdges(const Mosaic& mosaic, const std::array<Edge, 4>& edges,
                                                 double window_mm, std::size_t most_samples = kEdgeSamples);

}  // namespace dermap
