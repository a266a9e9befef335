// SPDX-License-Identifier: Apache-2.0
// Gauss-Legendre quadrature of any order on any interval.
#pragma once

#include <vector>

namespace dermap {

struct QuadratureRule {
  std::vector<double> nodes;  // ascending
  std::vector<double> weights;
};

QuadratureRule GaussLegendreRule(int order, double lower, double upper);

}  // namespace dermap
