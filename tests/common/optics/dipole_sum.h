// SPDX-License-Identifier: Apache-2.0
// The multipole in real space: the plain sum over dipoles of [Donner and Jensen 2005], the slow twin of the
// closed forms in common/optics/multipole.cpp. Shares no code with them.
#pragma once

namespace dermap {

struct DipoleSlab {
  double mu_a, mu_s_reduced;  // 1/mm
  double thickness_mm;
  double a_near, a_far;  // A of the faces
};

// Profiles in 1/mm^2 at distance r_mm from a pencil beam, per light that entered; images -`images` ...
// `images`.
double DipoleSumReflectance(const DipoleSlab& slab, double r_mm, int images = 400);
double DipoleSumTransmittance(const DipoleSlab& slab, double r_mm, int images = 400);

}  // namespace dermap
