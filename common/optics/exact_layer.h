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

#include "common/optics/exact_faces.h"

namespace dermap {

struct ExactLayer {
  double thickness = 1.0;  // optical; ignored for a half-space
  double albedo = 1.0;     // 0 to 1
  double kappa = 0.0;      // lateral frequency over sigma_t, >= 0
  ExactNeighbour above, below;
};

// Shares of the incident light. "normal" falls along the normal, just inside the upper face (what this face
// reflects is the caller's concern); "down" and "up" are diffuse, from the neighbours, just inside the upper
// or lower face.
struct ExactResponses {
  double r_normal = 0.0, t_normal = 0.0;  // scattered at least once
  double t_ballistic = 0.0;               // not scattered
  double r_ballistic = 0.0;               // not scattered, but mirrored by the lower face; not in r_normal
  double r_normal_single = 0.0;           // part of r_normal that was scattered exactly once
  double r_down = 0.0, t_down = 0.0;
  double r_up = 0.0, t_up = 0.0;
};
ExactResponses SolveExactLayer(const ExactFaces& faces, const ExactLayer& layer,
                               const ExactResolution& resolution = {});

}  // namespace dermap
