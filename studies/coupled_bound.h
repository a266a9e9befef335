// SPDX-License-Identifier: Apache-2.0
// What noise alone lets anybody know of every pixel of a patch when light spreads from each into the others.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "common/tissue/parameters.h"
#include "common/transport/forward_model.h"

namespace dermap {

// The information that noisy data hold about all unknowns of all pixels of a patch (Fisher's matrix): the
// exact Jacobian of the render, every pixel's light by every pixel's skin. Unknowns are in units of the
// parameters, parameter by parameter (kUnknownCount), pixel by pixel within. `noise`: one standard deviation,
// reflectance, one plane a band. Memory: 4 bytes * (6 pixels)^2,
// about twice that while it is made and five times in Bound; meant for up to some 30 x 30 pixels.
class CoupledInformation {
 public:
  CoupledInformation(const ForwardModel& model, const ParameterMaps& truth, const std::vector<PlaneF>& noise);

  // Cramer-Rao's bound: one standard deviation of what is free, one plane a parameter in the order of `free`.
  // A parameter is known to lie within the range of [D08 table 1] beforehand (variance range^2 / 12).
  std::vector<PlaneF> Bound(const std::vector<Parameter>& free) const;

 private:
  int width_, height_;
  Eigen::MatrixXf information_;  // scaled units (fit/parameter_space.h); the lower triangle
};

}  // namespace dermap
