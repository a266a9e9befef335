// SPDX-License-Identifier: Apache-2.0
// How the logarithm of an octave's reflectance answers to the free parameters: the rows of a pixel's
// equations.
#pragma once

#include <span>
#include <vector>

#include "fit/blur_share.h"
#include "fit/detail_model.h"
#include "fit/octave_levels.h"

namespace dermap {

// Derivatives of the logarithm of one band by the scaled free parameters, and how much of them skin's blur
// leaves.
struct OctaveRow {
  float blurred[kUnknownCount], unblurred[kUnknownCount];
  float epidermis_share;
};

// The absorbers of a band as its whole filter sees them. An octave's levels hold how reflectance answers to
// absorption at the filter's centre; to an absorber that is not gray over the filter (blood between 540 and
// 580 nm, carotene below 520 nm) it answers as the mean over the filter does, each wavelength weighed by how
// much it tells.
struct FilterAbsorbers {
  Absorbers center, epidermis, dermis;
  double junction = 1.0;  // of the absorber between the layers, over the centre's
};
FilterAbsorbers AbsorbersOf(const BandOptics& optics, const SkinPoint& skin);

// Makes the rows of an octave's pixels.
class RowMaker {
 public:
  // `blur`: [band], null: not blurred. `fixed`: of what is not free.
  RowMaker(const PatchProblem& problem, const OctaveLevel& level, const std::vector<BlurCurve>* blur,
           const SkinPoint& fixed);
  // Of all bands.
  void Fill(std::size_t pixel, std::span<OctaveRow> rows) const;

 private:
  SkinPoint PointOf(const FreeVector& position) const;

  const ParameterSpace& space_;
  const OctaveLevel& level_;
  const std::vector<BlurCurve>* blur_;
  SkinPoint fixed_;
  std::vector<FilterAbsorbers> absorbers_;  // [band], at the level's mean
};
// The octave's curves, or null where it is not blurred.
const std::vector<BlurCurve>* BlurOf(const DetailView& model, std::size_t octave);

}  // namespace dermap
