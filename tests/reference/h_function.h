// SPDX-License-Identifier: Apache-2.0
// Chandrasekhar's H function for isotropic scattering, from its own nonlinear equation: truth for half-spaces
// without faces, where the plane albedo of light along mu is 1 - H(mu) sqrt(1 - albedo).
#pragma once

#include <cmath>
#include <vector>

#include "tests/reference/quadrature.h"

namespace dermap::reference {

// 1 / H(mu) = sqrt(1 - albedo) + albedo/2 int_0^1 x H(x) / (mu + x) dx, by iteration.
inline double HFunction(double mu, double albedo) {
  const Rule rule = GaussLegendre(40, 0.0, 1.0);
  std::vector<double> h(rule.nodes.size(), 1.0);
  const auto right_side = [&](double at) {
    double sum = std::sqrt(1.0 - albedo);
    for (std::size_t i = 0; i < h.size(); ++i) {
      sum += 0.5 * albedo * rule.weights[i] * rule.nodes[i] * h[i] / (at + rule.nodes[i]);
    }
    return 1.0 / sum;
  };
  for (int iteration = 0; iteration < 300; ++iteration) {
    std::vector<double> next;
    for (const double node : rule.nodes) next.push_back(right_side(node));
    h = next;
  }
  return right_side(mu);
}

}  // namespace dermap::reference
