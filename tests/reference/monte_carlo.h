// SPDX-License-Identifier: Apache-2.0
// Truth with error bars: Monte Carlo of light in plane layers, independent of common/optics. Absorption is
// exp(-integral of mu_a along the path), so it may vary laterally; scattering, faces and exits are sampled.
// Lengths in mm. Source: Wang, Jacques, Zheng, Comput. Methods Programs Biomed. 47 (1995) 131, for the
// sampling of faces and HG.
#pragma once

#include <cstdint>
#include <vector>

#include "common/core/image.h"
#include "tests/reference/layer_stack.h"

namespace dermap::reference {

struct Estimate {
  double value = 0.0;
  double standard_error = 0.0;
};

// Normal incidence from above. Specular reflection of the first face is never in a result, its light counts
// as fallen.
enum class Beam { kPencil, kWindow };

struct MonteCarloScene {
  LayerStack stack;
  Beam beam = Beam::kPencil;
  // Images and windows: width x height pixels; the window is exactly the image, from (0, 0) mm. A pencil
  // falls on the image's middle. Without an image the light is a pencil, and totals are also those of wide
  // light.
  int width = 0, height = 0;
  double pixel_size_mm = 0.0;
  // Absorption of a layer by pixel, 1/mm, replicated outwards; empty planes use Layer::mu_a. One per layer,
  // or none.
  std::vector<PlaneF> mu_a;
  std::vector<PlaneF> absorber_below;  // likewise for Layer::absorber_below
  bool black_tape = false;             // outside the window the first face absorbs what reaches it from below
  bool periodic = false;               // the light outside the image goes on and the maps repeat: wide light
  std::vector<double> radial_edges_mm;  // rings of R(r) and T(r), ascending, for a pencil
};

struct MonteCarloOptions {
  std::uint64_t photons = 100000;
  std::uint64_t seed = 1;
  int threads = 1;
  // Photons whose weight falls below this play roulette for ten times their weight.
  double roulette_weight = 1e-4;
};

struct MonteCarloResult {
  std::uint64_t photons = 0;
  std::uint64_t seed = 0;
  double specular = 0.0;
  Estimate reflectance, transmittance;  // per photon that falls
  Estimate ballistic;                   // part of transmittance that never scattered
  Estimate single_scattering;           // part of reflectance that scattered once
  std::vector<Estimate> radial_reflectance, radial_transmittance;  // 1/mm^2
  // Per light that falls on a pixel of a window; for a pencil: per photon and pixel.
  Plane<double> reflectance_image, reflectance_image_error;
  Plane<double> transmittance_image, transmittance_image_error;
};

// The same for any number of threads: photons come in batches, each with its own generator.
MonteCarloResult RunMonteCarlo(const MonteCarloScene& scene, const MonteCarloOptions& options);

}  // namespace dermap::reference
