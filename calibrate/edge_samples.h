// SPDX-License-Identifier: Apache-2.0
// Within this folder: the photosites beside the window's edges, as the model of an edge sees them.
#pragma once

#include <array>
#include <vector>

#include "calibrate/edge_model.h"

namespace dermap {

struct EdgeReach {
  double inside_px, outside_px, px_per_mm;
};

struct EdgeSample {
  double s, t;   // inwards of and along the edge as it was thought to be
  double value;  // reflectance
  double weight;
  int edge;
  int segment;  // of all edges
  double u;     // along within the segment, -1 ... 1
};

struct EdgeSamples {
  std::vector<EdgeSample> samples;
  std::array<EdgeReach, 4> reach{};
  int segments = 0;  // stretches of the edges with levels of their own
};

EdgeSamples CollectEdgeSamples(const Mosaic& mosaic, const std::array<Edge, 4>& edges, double window_mm,
                               std::size_t most_samples);

}  // namespace dermap
