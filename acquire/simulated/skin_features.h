// SPDX-License-Identifier: Apache-2.0
// What lies in simulated skin: smooth variation, freckles, veins, tattoos, each drawn into the parameter
// maps.
#pragma once

#include <cstdint>
#include <vector>

#include "common/tissue/parameters.h"

namespace dermap {

struct Variation {
  double value = 0.0;
  double amplitude = 0.0;  // standard deviation
  double correlation_mm = 1.5;
};

struct FreckleField {
  int count = 0;
  double smallest_radius_mm = 0.2;
  double largest_radius_mm = 0.6;
  double edge_mm = 0.15;  // width of the soft edge
  double C_m = 0.0;       // added in a freckle's middle
  double beta_m = 0.0;    // added in a freckle's middle
};

struct Point_mm {
  double x, y;
};

// A soft line: a vein (adds to C_hd) or a tattoo (adds to the junction's absorbance).
struct SoftLine {
  std::vector<Point_mm> points;
  double width_mm = 0.5;
  double edge_mm = 0.3;
  double amount = 0.0;
};

// Each works on planes of `pixel_size_mm`; results depend on the seed and the index of the feature only.
void DrawVariation(PlaneF& plane, double pixel_size_mm, const Variation& variation, std::uint64_t seed,
                   int index);
void DrawFreckles(ParameterMaps& maps, double pixel_size_mm, const FreckleField& field, std::uint64_t seed,
                  int index);
// Draws into a plane of what lines add: where lines meet, the stronger one counts.
void DrawLine(PlaneF& added, double pixel_size_mm, const SoftLine& line);

// Keeps every map inside [D08 table 1].
void ClampToBounds(ParameterMaps& maps);

}  // namespace dermap
