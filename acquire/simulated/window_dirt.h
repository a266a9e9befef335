// SPDX-License-Identifier: Apache-2.0
// What makes a real window less than a clean square of light: a cut with round corners and frayed edges,
// hairs, a shadow; or another cut beside it. Positions are in mm from the window's top left corner.
#pragma once

#include <cstdint>
#include <vector>

#include "acquire/simulated/bench_config.h"
#include "acquire/simulated/pinhole_view.h"

namespace dermap {

class WindowDirt {
 public:
  WindowDirt(const BenchConfig& config, double window_mm, std::uint64_t seed);
  bool InWindow(Point2 p) const noexcept;  // skin is seen, not tape
  double Clear(Point2 p) const noexcept;   // share of the light that no hair takes
  double Lit(Point2 p) const noexcept;     // share of the light outside of the shadow

 private:
  struct Fibre {
    int side;  // clockwise from the top
    double at_mm, half_width_mm, length_mm;
  };
  struct Hair {
    double nx, ny, distance_mm;  // line nx x + ny y = distance
  };
  double window_mm_, second_mm_, corner_mm_, half_hair_mm_, shadow_;
  std::vector<Fibre> fibres_;
  std::vector<Hair> hairs_;
};

}  // namespace dermap
