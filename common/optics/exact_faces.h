// SPDX-License-Identifier: Apache-2.0
// Directions of light inside a plane layer, what its two faces reflect of them, and how diffuse light falls
// in.
#pragma once

#include <complex>
#include <limits>
#include <vector>

namespace dermap {

// How finely the integrals of exact_layer.h are resolved. With the defaults totals are within 1e-4 of their
// limit.
struct ExactResolution {
  int free_nodes = 24;               // of the kernel without faces
  int nodes_per_interval = 8;        // of angles, between the critical angles of the faces
  int fine_nodes_per_interval = 16;  // likewise, for what is known in closed form
  double azimuths_per_kappa = 2.0;   // azimuths of face terms: 2 + this * kappa, in a quarter turn
  int max_azimuths = 16;
  double smallest_element = 0.1;  // optical depth
  double element_ratio = 3.0;
  double largest_element = 1.5;        // times the depth in which light dies away to 1/e
  double least_largest_element = 0.0;  // optical depth: of a slab, whatever that depth
};

struct ExactFaces {
  struct Direction {
    double mu, weight;   // weights of d mu sum to 1
    double top, bottom;  // reflectance of each face
  };
  std::vector<Direction> directions, fine_directions;
  double normal_top = 0.0, normal_bottom = 0.0;  // reflectance at normal incidence
  bool half_space = false;                       // nothing comes back from below
};
// black_above: what meets the upper face from inside leaves, and none of it counts as reflected.
ExactFaces MakeExactFaces(double n_above, double n, double n_below, bool black_above, bool half_space,
                          const ExactResolution& resolution = {});

// The layer from which diffuse light comes. Its light is not Lambertian, and under lateral structure it leans
// away from where it is brightest; both follow from the neighbour's source function, taken as uniform in a
// slab and as dying away like diffuse light in a half-space. Only directions depend on this, so a typical
// neighbour does.
struct ExactNeighbour {
  double extinction = 0.0;  // sigma_t of the neighbour over the layer's own; 0: its light is Lambertian
  double albedo = 0.0;
  double index = 1.0;  // refractive index of the neighbour over the layer's own
  double thickness = std::numeric_limits<double>::infinity();  // optical, of the neighbour
};

// Radiance of the neighbour's light in the direction (mu, azimuth) inside the layer, up to a factor, before
// the face; kappa is the layer's own.
std::complex<double> DiffuseRadiance(const ExactNeighbour& neighbour, double mu, double cos_azimuth,
                                     double kappa);

// kappa in the neighbour's own optical depth, as DiffuseRadiance uses it.
double SaturatedKappa(const ExactNeighbour& neighbour, double kappa);

// How fast light dies away with optical depth far from the faces, by diffusion, but never faster than
// unscattered light.
double DecayRate(double albedo, double kappa);

}  // namespace dermap
