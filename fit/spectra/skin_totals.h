// SPDX-License-Identifier: Apache-2.0
// Exact total reflectance of homogeneous two-layer skin as a table of three numbers, quick enough to fit
// spectra.
#pragma once

#include "common/core/progress.h"
#include "common/tissue/tissue.h"
#include "fit/spectra/grid3.h"

namespace dermap {

// The dermis is bottomless, so that only mu_a / mu_s' of it matters; of the epidermis mu_s' d as well. For
// given refractive indices, anisotropy and junction absorbance the total is a function of these three.
// Outside the ranges below the nearest skin within them is taken.
class SkinTotals {
 public:
  SkinTotals(const TissueConfig& config, const ProgressFunction& progress);

  // ln R over ln(mu_s' d) of the epidermis, ln(mu_a / mu_s') of the epidermis and of the
  // dermis.
  const Grid3& log_reflectance() const noexcept { return grid_; }

  static const std::array<GridAxis, 3>& Axes();

 private:
  Grid3 grid_;
};

}  // namespace dermap
