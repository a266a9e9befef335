// SPDX-License-Identifier: Apache-2.0
// Newton's method on the Legendre polynomial, from Tricomi's asymptotic estimate of its zeros.
#include "common/optics/gauss_legendre.h"

#include <cmath>
#include <numbers>

namespace dermap {

QuadratureRule GaussLegendreRule(int order, double lower, double upper) {
  QuadratureRule rule{std::vector<double>(order), std::vector<double>(order)};
  for (int i = 0; i < order; ++i) {
    double x = -std::cos(std::numbers::pi * (i + 0.75) / (order + 0.5));
    double slope = 0.0;
    for (int iteration = 0; iteration < 20; ++iteration) {
      double previous = 0.0, value = 1.0;
      for (int n = 0; n < order; ++n) {
        const double next = ((2 * n + 1) * x * value - n * previous) / (n + 1);
        previous = value;
        value = next;
      }
      slope = order * (x * value - previous) / (x * x - 1.0);
      const double step = value / slope;
      x -= step;
      if (std::abs(step) < 1e-15) break;
    }
    rule.nodes[i] = 0.5 * (lower + upper) + 0.5 * (upper - lower) * x;
    rule.weights[i] = (upper - lower) / ((1.0 - x * x) * slope * slope);
  }
  return rule;
}

}  // namespace dermap
