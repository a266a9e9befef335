// SPDX-License-Identifier: Apache-2.0
// The light that a spectrophotometer with a small aperture loses: what leaves the skin beside the aperture,
// from the exact R(r) of common/optics. Lengths in mm.
#pragma once

#include "common/core/progress.h"
#include "common/tissue/tissue.h"
#include "fit/spectra/grid3.h"

namespace dermap {

// Concentric discs on the skin. 0: so wide that nothing is lost.
struct Aperture {
  double measured_radius_mm = 0.0;
  double illuminated_radius_mm = 0.0;

  bool IsFinite() const { return measured_radius_mm > 0.0 && illuminated_radius_mm > 0.0; }
};

// Of light that travels a distance r sideways and would have been measured on an opaque white, the share that
// still is: the overlap of the two discs, one moved by r, over the smaller disc.
double DiscOverlap(const Aperture& aperture, double distance_mm);

// Share of the total reflectance that is lost: int R(r) (1 - overlap(r)) 2 pi r dr / R, exact where it is
// sampled (isotropic scattering; the dermis scatters half as much as the epidermis), interpolated in between.
class EdgeLoss {
 public:
  // Throws InputError for radii outside 0.5 to 50 mm.
  EdgeLoss(const Aperture& aperture, const TissueConfig& config, const ProgressFunction& progress);

  // ln(share) over ln(mu_s') of the epidermis, ln(mu_a d) of the epidermis and ln(mu_a) of
  // the dermis. A loss of 1e-7 and less counts as 1e-7.
  const Grid3& log_loss() const noexcept { return grid_; }

  static const std::array<GridAxis, 3>& Axes();
  static constexpr double kThickness_mm = 0.06;  // for which it is sampled; others by the same mu_a d, twice
                                                 // as thick ones with up to a third too much loss

 private:
  Grid3 grid_;
};

}  // namespace dermap
