// SPDX-License-Identifier: Apache-2.0
// What tables of single layers get wrong about both together. A table knows a layer under the light of a
// typical neighbour, whose directions differ a little from those of the real one: up to 0.7 % of the
// reflectance. Skin solved with both of its layers (homogeneous_skin.h) tells; the ratio is a smooth function
// of both absorptions and the junction, kept as a polynomial.
#pragma once

#include <array>

#include "common/tissue/tissue.h"

namespace dermap {

struct BandTables;

struct TotalsCorrection {
  static constexpr int kDegree = 6;          // in the logarithms of mu_a together
  static constexpr int kJunctionDegree = 2;  // in A^2 = exp(-2 P)
  static constexpr int kLogTerms = (kDegree + 1) * (kDegree + 2) / 2;
  static constexpr int kTerms = kLogTerms * (kJunctionDegree + 1);

  std::array<double, kTerms> coefficients{};  // all 0: the ratio is 1

  // True reflectance of uniform skin over the tables', and its derivatives. Beyond the tables' mu_a (1/mm) as
  // at their ends.
  struct Ratio {
    double value = 1.0, d_mu_a_epidermis = 0.0, d_mu_a_dermis = 0.0, d_junction_absorbance = 0.0;
  };
  Ratio At(double mu_a_epidermis, double mu_a_dermis, double junction_absorbance) const noexcept;
  bool IsOne() const noexcept;
};

// Of tables that the source `exact` made. Source of the truth: discrete ordinates, both layers at once.
TotalsCorrection FitTotalsCorrection(const BandTables& tables, const TissueConfig& config);

}  // namespace dermap
