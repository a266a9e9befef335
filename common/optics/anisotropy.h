// SPDX-License-Identifier: Apache-2.0
// What a forward peak of scattering does to the totals of each layer's responses, as factors on those of
// isotropic scattering at the same reduced scattering: by discrete ordinates, with the neighbours' light of
// exact_faces.h.
#pragma once

#include "common/optics/profile_source.h"

namespace dermap {

// Totals at the layer's own anisotropy, conventions as in profile_source.h. `t_ballistic` is what crosses as
// if scattering were isotropic, by similarity: light that real scattering has turned by little goes on as
// unscattered.
struct EpidermisTotals {
  double r_forward = 0.0, t_forward = 0.0, r_backward = 0.0, t_backward = 0.0, t_ballistic = 0.0;
};
struct DermisTotals {
  double r_diffuse = 0.0, r_normal = 0.0;
};
EpidermisTotals SolveEpidermisTotals(const EpidermisOptics& optics);
DermisTotals SolveDermisTotals(const DermisOptics& optics);

// Multiplies transforms of isotropic scattering by the ratio of the totals; their shapes stay.
void ApplyAnisotropy(const EpidermisOptics& optics, EpidermisTransforms& transforms);
void ApplyAnisotropy(const DermisOptics& optics, DermisTransforms& transforms);

}  // namespace dermap
