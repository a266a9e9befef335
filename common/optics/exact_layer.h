// SPDX-License-Identifier: Apache-2.0
// Exact response of one plane layer with isotropic scattering at one lateral frequency, in optical units.
//
// The light's source function S(x) = albedo * phi(x) at optical depth x obeys an integral equation that is
// exact at each lateral frequency k; with kappa = k / sigma_t (derived in docs/optics.md):
//   phi(x) = phi_0(x) + albedo * int K(x, y) phi(y) dy,
//   K(x, y) = 1/2 int_0^1 dmu/mu <exp(-q |x-y|)> + images in the faces,
//   q = (1 + i kappa sqrt(1 - mu^2) cos(azimuth)) / mu, and <> the mean over azimuth.
// It is solved by Galerkin's method on graded elements (exact_mesh.h), so that what leaves the layer, a
// product of two such functions, has the square of their small error.
#pragma once

#include <vector>

namespace dermap {

// How finely the integrals are resolved; the defaults keep totals within 1e-4 of their limit (see the tests).
struct ExactResolution {
  int free_nodes = 24;              // of the kernel without faces
  int nodes_per_interval = 8;       // of angles, between the critical angles of the faces
  double azimuths_per_kappa = 1.5;  // azimuths of face terms: 2 + this * kappa, in a quarter turn
  int max_azimuths = 16;
  double smallest_element = 0.1;  // optical depth
  double element_ratio = 3.0;
  double largest_element = 1.5;  // times the depth in which light dies away to 1/e
};

// Directions inside the layer and what its two faces reflect of them. Faces are Fresnel's.
struct ExactFaces {
  struct Direction {
    double mu, weight;   // weights of d mu sum to 1
    double top, bottom;  // reflectance of each face
  };
  std::vector<Direction> directions;
  double normal_top = 0.0, normal_bottom = 0.0;  // reflectance at normal incidence
  // Diffuse light inside a face is (1 - F(mu)) (1 + tilt mu): Lambertian in the neighbour, but for the tilt.
  // Light that comes up from a dermis that absorbs is fainter along the normal than Lambertian, from a clear
  // one brighter; kTiltUp is a compromise that makes the worst two-layer total 0.6 % wrong instead of 0.8 %.
  static constexpr double kTiltUp = -0.1;
  double tilt_down = 0.0, tilt_up = kTiltUp;
  double open_top = 0.0, open_bottom = 0.0;  // int_0^1 (1 - F) (1 + tilt mu) mu dmu
  bool half_space = false;                   // nothing comes back from below
};
// black_above: what meets the upper face from inside leaves, and none of it counts as reflected.
ExactFaces MakeExactFaces(double n_above, double n, double n_below, bool black_above, bool half_space,
                          const ExactResolution& resolution = {});

// Shares of incident light at lateral frequency kappa * sigma_t. "normal" falls along the normal, just inside
// the upper face (the share that this face reflects is the caller's); "down" and "up" are diffuse, just
// inside the upper or lower face: the light of a uniformly bright neighbour, (1 - F(mu)) times Lambertian.
struct ExactResponses {
  double r_normal = 0.0, t_normal = 0.0;  // scattered at least once
  double t_ballistic = 0.0;               // not scattered
  double r_ballistic = 0.0;               // not scattered, but mirrored by the lower face; not in r_normal
  double r_normal_single = 0.0;           // part of r_normal that was scattered exactly once
  double r_down = 0.0, t_down = 0.0;
  double r_up = 0.0, t_up = 0.0;
};
// albedo in [0, 1]; for a half-space `thickness` (optical) is ignored and albedo must be below 1 where kappa
// is 0.
ExactResponses SolveExactLayer(const ExactFaces& faces, double thickness, double albedo, double kappa,
                               const ExactResolution& resolution = {});

}  // namespace dermap
