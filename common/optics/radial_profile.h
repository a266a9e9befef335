// SPDX-License-Identifier: Apache-2.0
// R(r) of the two-layer skin under a pencil beam, 1/mm^2, from the transforms of a source of profiles.
#pragma once

#include <span>
#include <vector>

#include "common/optics/profile_source.h"

namespace dermap {

// R(r) = 1/(2 pi) int k R(k) J_0(k r) dk, as weights on the transform's samples, made once for all skins.
// Where the source knows single scattering, that part, which is singular at r = 0, is integrated in real
// space instead.
class RadialProfile {
 public:
  explicit RadialProfile(std::span<const double> radii_mm);  // each > 0

  // Frequencies at which the transforms are wanted for a skin whose larger sigma_t is `mu_t`, 1/mm: the first
  // of a fixed list. Beyond them a transform is taken to go on as 1 / k^2.
  static std::span<const double> Frequencies_per_mm(double mu_t);

  std::vector<double> At(const EpidermisOptics& optics, const EpidermisTransforms& epidermis,
                         const DermisTransforms& dermis, double junction_absorbance) const;
  const std::vector<double>& radii_mm() const { return radii_mm_; }

 private:
  std::vector<double> radii_mm_;
  std::vector<std::vector<double>> weights_;  // [radius][frequency]
};

// Light along the normal that leaves the epidermis after exactly one scattering, 1/mm^2; faces but the
// surface, which hardly reflect, are left out.
double SingleScatteringProfile(const EpidermisOptics& optics, double radius_mm);

}  // namespace dermap
