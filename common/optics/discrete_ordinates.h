// SPDX-License-Identifier: Apache-2.0
// What a plane layer does with light from every direction, without lateral structure, for any anisotropy:
// discrete ordinates, solved by eigenvectors [Stamnes, Tsay, Wiscombe, Jayaweera 1988], and stacks of such
// layers by adding.
#pragma once

#include <Eigen/Core>
#include <limits>

#include "common/optics/angular_grid.h"

namespace dermap {

struct PlaneLayer {
  double mu_a = 0.0;        // 1/mm
  double mu_s = 1.0;        // 1/mm, of real events
  double anisotropy = 0.0;  // g, Henyey-Greenstein
  double thickness_mm = std::numeric_limits<double>::infinity();
};

// Reflection and transmission of anything plane as matrices on fluxes, one a node of the grid, [out][in].
// "down" is light that comes from above.
struct LightOperators {
  Eigen::MatrixXd r_down, t_down, r_up, t_up;
};

// The layer alone, in medium `medium` of the grid, without its faces. What is scattered within the angle that
// the grid resolves counts as not scattered (delta-M [Wiscombe 1977]).
LightOperators SolvePlaneLayer(const AngularGrid& grid, int medium, const PlaneLayer& layer);

// The smooth face between two media, with a thin absorber on it: light that crosses is multiplied by
// exp(-absorbance).
LightOperators SolveFace(const AngularGrid& grid, int above, int below, double absorbance = 0.0);

LightOperators Add(const LightOperators& above, const LightOperators& below);

}  // namespace dermap
