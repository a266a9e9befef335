// SPDX-License-Identifier: Apache-2.0
// R(r) of the two-layer skin under a pencil beam, 1/mm^2, from the transforms of a source of profiles.
#pragma once

#include <span>
#include <vector>

#include "common/optics/profile_source.h"

namespace dermap {

// The two-layer response at each frequency [D08 eq. 3, mended; eq. 8]:
// R1+ + (Tb R2n + T1+ R2d) A^2 T1- / (1 - A^2 R1- R2d), A = exp(-junction_absorbance).
std::vector<double> TwoLayerTransform(const EpidermisTransforms& epidermis, const DermisTransforms& dermis,
                                      double junction_absorbance);

// R(r) = 1/(2 pi) int k R(k) J_0(k r) dk, as weights on the transform's samples, made once for all skins.
// Where the source knows single scattering, that part, which is singular at r = 0, is integrated in real
// space instead.
class RadialProfile {
 public:
  // k_per_mm: 0, then ascending, dense enough for polynomials of degree 5 in between; r > 0.
  RadialProfile(std::span<const double> k_per_mm, std::span<const double> radii_mm);

  std::vector<double> At(const EpidermisOptics& optics, const EpidermisTransforms& epidermis,
                         const DermisTransforms& dermis, double junction_absorbance) const;
  const std::vector<double>& radii_mm() const { return radii_mm_; }
  const std::vector<double>& k_per_mm() const { return k_per_mm_; }

 private:
  std::vector<double> k_per_mm_;
  std::vector<double> radii_mm_;
  std::vector<std::vector<double>> weights_;  // [radius][frequency]
};

// Light along the normal that leaves the epidermis after exactly one scattering, 1/mm^2; faces but the
// surface, which hardly reflect, are left out.
double SingleScatteringProfile(const EpidermisOptics& optics, double radius_mm);

}  // namespace dermap
