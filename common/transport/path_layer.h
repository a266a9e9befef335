// SPDX-License-Identifier: Apache-2.0
// One layer of a scene as the path engine sees it: a few path lengths, what absorption takes from light that
// enters or leaves at each pixel along each of them, and how each of them spreads.
//
// The response between entry x' and exit x is, over path lengths L_j,
//   P(x, x') = sum_j a_j(x) p_j(x - x') a_j(x'),   a_j = S * exp(-mu_a L_j / 2):
// half of a path lies near either end, so it is absorbed as if all skin had the mean of both ends'
// absorption; S is a Gaussian as wide as such a half strays (kSpread), so an end is the mean of its
// neighbourhood's transmittances: light that survives is light that strayed to where it is bright. [D08 4.1]
// takes the absorption at the exit alone for the whole path, which is not reciprocal and, against Monte
// Carlo, far from it at a sharp edge (docs/heterogeneous_skin.md); it is kept as Coupling::kGather, P(x, x')
// = sum_j exp(-mu_a(x) L_j) p_j(x - x').
#pragma once

#include <vector>

#include "common/optics/path_kernels.h"
#include "common/transport/blur.h"
#include "common/transport/forward_model.h"
#include "common/transport/path_grid.h"

namespace dermap {

// The range of mu_a in a map, wider by some, on a grid of its logarithm: maps that differ little are seen
// through the same path lengths, so that a render is a smooth function of its maps.
struct AbsorptionRange {
  double lowest, highest;  // 1/mm, within the tables
};
AbsorptionRange RangeOf(const PlaneF& mu_a);

class PathLayer {
 public:
  // `mu_a` of the patch, 1/mm. Keeps its memory between calls.
  void Set(std::span<const TransformTable* const> responses, const PlaneF& mu_a, double mean_free_path_mm,
           double pixel_size_mm, Coupling coupling, double tolerance);

  int count() const { return paths_.count(); }
  double length_mm(int j) const { return paths_.lengths_mm[j]; }
  const AbsorptionRange& range() const { return range_; }
  // Of response `r` as it was passed to Set, path length j.
  const RadialTransform& kernel(int r, int j) const { return kernels_[r][j]; }
  double total(int r, int j) const { return paths_.kernels[r][j][0]; }
  // On the patch; what light keeps at the end where it leaves, and at the one where it enters.
  const PlaneF& leaving(int j) const { return attenuation_[j]; }
  bool attenuates_entering() const { return coupling_ == Coupling::kReciprocal; }

 private:
  Coupling coupling_ = Coupling::kReciprocal;
  AbsorptionRange range_{};
  ScenePaths paths_;
  std::vector<std::vector<RadialTransform>> kernels_;
  std::vector<PlaneF> attenuation_;
  SeparableBlur blur_{Border::kMirror};
};

}  // namespace dermap
