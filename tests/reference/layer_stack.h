// SPDX-License-Identifier: Apache-2.0
// What both judges are asked about: plane layers between two media; mm and 1/mm. Shares nothing with
// common/optics.
#pragma once

#include <limits>
#include <vector>

namespace dermap::reference {

inline constexpr double kInfinite = std::numeric_limits<double>::infinity();

struct Layer {
  double thickness_mm = kInfinite;
  double mu_a = 0.0;  // 1/mm
  double mu_s = 1.0;  // 1/mm
  double g = 0.0;     // Henyey-Greenstein; 0 is isotropic
  double n = 1.4;
  // Absorbance P of an infinitely thin absorber on the layer's lower face: light that crosses is multiplied
  // by exp(-P), what the face reflects is not.
  double absorber_below = 0.0;
};

// From the top downwards. Light comes from above, in the medium n_above.
struct LayerStack {
  double n_above = 1.0;
  std::vector<Layer> layers;
  double n_below = 1.0;
};

}  // namespace dermap::reference
