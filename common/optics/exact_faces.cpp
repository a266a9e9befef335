// SPDX-License-Identifier: Apache-2.0
// Angular quadrature split at the critical angles, and the radiance of diffuse neighbours.
#include "common/optics/exact_faces.h"

#include <algorithm>
#include <cmath>

#include "common/optics/fresnel.h"
#include "common/optics/gauss_legendre.h"

namespace dermap {
namespace {

constexpr double kLargestLean = 3.0;  // of kappa in the neighbour's radiance

// Angles are split where a face begins to reflect totally; between, the rule runs in the cosine of the
// thinnest medium that still carries the light, in which Fresnel's formulas are smooth.
std::vector<ExactFaces::Direction> Directions(double n, const std::vector<double>& indices, int nodes) {
  std::vector<ExactFaces::Direction> directions;
  double lower = 0.0;  // of n sin(theta)
  for (const double index : indices) {
    const double widest = std::sqrt(1.0 - lower * lower / (index * index));
    const QuadratureRule rule = GaussLegendreRule(nodes, 0.0, widest);
    for (int i = 0; i < nodes; ++i) {
      const double sine = index / n * std::sqrt(1.0 - rule.nodes[i] * rule.nodes[i]);  // Snell
      const double mu = std::sqrt(1.0 - sine * sine);
      const double weight = rule.weights[i] * rule.nodes[i] * index * index / (n * n * mu);
      directions.push_back({.mu = mu, .weight = weight, .top = 0.0, .bottom = 0.0});
    }
    lower = index;
  }
  return directions;
}

}  // namespace

ExactFaces MakeExactFaces(double n_above, double n, double n_below, bool black_above, bool half_space,
                          const ExactResolution& resolution) {
  std::vector<double> indices{n};
  if (n_above < n) indices.push_back(n_above);
  if (n_below < n && !half_space) indices.push_back(n_below);
  std::sort(indices.begin(), indices.end());
  indices.erase(std::unique(indices.begin(), indices.end()), indices.end());
  const auto top = [&](double mu) { return black_above ? 0.0 : FresnelReflectance(mu, n, n_above); };
  const auto bottom = [&](double mu) { return half_space ? 0.0 : FresnelReflectance(mu, n, n_below); };
  ExactFaces faces;
  faces.half_space = half_space;
  faces.directions = Directions(n, indices, resolution.nodes_per_interval);
  faces.fine_directions = Directions(n, indices, resolution.fine_nodes_per_interval);
  for (auto* directions : {&faces.directions, &faces.fine_directions}) {
    for (ExactFaces::Direction& d : *directions) {
      d.top = top(d.mu);
      d.bottom = bottom(d.mu);
    }
  }
  faces.normal_top = top(1.0);
  faces.normal_bottom = bottom(1.0);
  return faces;
}

double DecayRate(double albedo, double kappa) {
  return std::sqrt(std::min(1.0, 3.0 * (1.0 - albedo)) + kappa * kappa);
}

double SaturatedKappa(const ExactNeighbour& neighbour, double kappa) {
  if (neighbour.extinction <= 0.0) return 0.0;
  const double there = kappa / neighbour.extinction;
  return there / std::sqrt(1.0 + there * there / (kLargestLean * kLargestLean));
}

std::complex<double> DiffuseRadiance(const ExactNeighbour& neighbour, double mu, double cos_azimuth,
                                     double kappa) {
  if (neighbour.extinction <= 0.0) return 1.0;
  const double sine = std::min(1.0, std::sqrt(1.0 - mu * mu) / neighbour.index);  // Snell
  const double cosine = std::sqrt(1.0 - sine * sine);
  // Under structure finer than the neighbour's mean free path little light remains, and its lean does not
  // matter: the phase saturates, so that few azimuths resolve it.
  const double kappa_there = SaturatedKappa(neighbour, kappa);
  const double phase = kappa_there * sine * cos_azimuth;
  if (std::isinf(neighbour.thickness)) {
    // int_0^inf exp(-s x) exp(-q x) dx / mu with q = (1 + i phase) / mu
    return 1.0 / std::complex<double>(1.0 + DecayRate(neighbour.albedo, kappa_there) * cosine, phase);
  }
  const std::complex<double> rate(1.0, phase);  // int_0^tau exp(-q x) dx / mu
  const double least = 1e-6;
  return (1.0 - std::exp(-rate * neighbour.thickness / std::max(cosine, least))) / rate;
}

}  // namespace dermap
