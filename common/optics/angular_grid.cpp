// SPDX-License-Identifier: Apache-2.0
// Gauss-Legendre nodes between the critical angles, and Gauss-Radau nodes where the normal is an end.
#include "common/optics/angular_grid.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "common/optics/gauss_legendre.h"

namespace dermap {
namespace {

// Values of the Legendre polynomials of degree n - 1 and n.
std::pair<double, double> LegendrePair(int n, double x) {
  double before = 0.0, value = 1.0;
  for (int l = 0; l < n; ++l) {
    const double next = ((2 * l + 1) * x * value - l * before) / (l + 1);
    before = value;
    value = next;
  }
  return {before, value};
}

// On [0, 1] with 1 as the last node: on [-1, 1] the others are the zeros of P_{n-1} - P_n [Abramowitz and
// Stegun 25.4.31, mirrored], found by bisection between those of P_n.
QuadratureRule RadauRule(int n) {
  const QuadratureRule legendre = GaussLegendreRule(n, -1.0, 1.0);
  const auto difference = [n](double x) {
    const auto [lower, upper] = LegendrePair(n, x);
    return lower - upper;
  };
  QuadratureRule rule;
  for (int i = 0; i + 1 < n; ++i) {
    double low = legendre.nodes[i], high = legendre.nodes[i + 1];
    const bool rising = difference(low) < 0.0;
    for (int step = 0; step < 60; ++step) {
      const double middle = 0.5 * (low + high);
      ((difference(middle) < 0.0) == rising ? low : high) = middle;
    }
    const double x = 0.5 * (low + high), p = LegendrePair(n, x).first;
    rule.nodes.push_back(0.5 * (1.0 + x));
    rule.weights.push_back(0.5 * (1.0 + x) / (n * n * p * p));
  }
  rule.nodes.push_back(1.0);
  rule.weights.push_back(1.0 / (n * n));
  return rule;
}

}  // namespace

AngularGrid MakeAngularGrid(std::span<const double> indices, int nodes_per_interval) {
  assert(!indices.empty() && nodes_per_interval >= 2);
  std::vector<double> distinct(indices.begin(), indices.end());
  std::sort(distinct.begin(), distinct.end());
  distinct.erase(std::unique(distinct.begin(), distinct.end()), distinct.end());
  // In each interval the rule runs in the cosine of the thinnest medium that still carries the light, in
  // which Fresnel's formulas are smooth. n^2 mu d mu is the same in every medium.
  std::vector<double> sine, flux;  // n sin(theta), and n^2 mu d mu
  double lower = 0.0;
  for (const double index : distinct) {
    const double widest = std::sqrt(1.0 - lower * lower / (index * index));
    const QuadratureRule rule =
        lower == 0.0 ? RadauRule(nodes_per_interval) : GaussLegendreRule(nodes_per_interval, 0.0, widest);
    for (int i = nodes_per_interval - 1; i >= 0; --i) {
      const double mu = rule.nodes[i];
      sine.push_back(index * std::sqrt(1.0 - mu * mu));
      flux.push_back(index * index * mu * rule.weights[i]);
    }
    lower = index;
  }
  AngularGrid grid;
  for (const double index : indices) {
    const int count = static_cast<int>(std::lower_bound(sine.begin(), sine.end(), index) - sine.begin());
    Eigen::VectorXd mu(count), weight(count);
    for (int i = 0; i < count; ++i) {
      mu(i) = std::sqrt(1.0 - sine[i] * sine[i] / (index * index));
      weight(i) = flux[i] / (index * index * mu(i));
    }
    grid.n.push_back(index);
    grid.mu.push_back(mu);
    grid.weight.push_back(weight);
  }
  return grid;
}

}  // namespace dermap
