// SPDX-License-Identifier: Apache-2.0
// Tables of a band with a width: the wavelengths that stand for its filter's curve, and total responses at
// each.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "common/transport/forward_model.h"

namespace dermap {

struct FilterNode {
  double wavelength_nm;
  double weight;  // all sum to 1
};

// Gauss-Hermite nodes of the band's Gaussian filter, ascending, an odd number (one where the width is 0):
// five up to 10 nm of width, then two more for every 10 nm, less those of a thousandth of the light that lie
// beyond 350-1000 nm.
std::vector<FilterNode> FilterNodes(const Band& band);

// A table whose first Gaussian carries the whole total: enough for closed forms (TotalReflectance), and
// hundreds of times cheaper than fitting profiles. Never convolve with it.
BandTables BuildBandTotals(const ProfileSource& source, double wavelength_nm, const TissueConfig& tissue);

// All bands, their nodes built in parallel. `all_profiles`: whether every node will be rendered; if not, only
// the centres have profiles and the others totals.
std::vector<BandOptics> BuildBandOptics(const Chromophores& chromophores, const ProfileSource& source,
                                        const TissueConfig& tissue, std::span<const Band> bands,
                                        bool all_profiles, const ProgressFunction& progress);

// How many terms leave less than kSeriesRemainder of the light that has crossed the dermis once, in the
// lightest skin of table 1 that is plausible, where light goes back and forth longest. Closing the series
// takes off most of that again.
inline constexpr double kSeriesRemainder = 1e-2;
int AutomaticTerms(const BandOptics& band, const TissueConfig& tissue);

// Totals of a band's responses over the table, for evaluation in many pixels whose table positions are known.
class LocalTotals {
 public:
  explicit LocalTotals(const BandTables& tables);

  // BandTables::TotalReflectance; `transmittance` is A = exp(-P) of the junction.
  float Reflectance(TablePosition epidermis, TablePosition dermis, float transmittance) const noexcept;
  // What leaves without having been in the dermis, R1+.
  float SurfaceReflectance(TablePosition epidermis) const noexcept { return At(r1_forward_, epidermis); }
  // What one more passage down and up is to the last, A^2 R1- R2: the quotient of the series of [D08 eq. 7].
  float Quotient(TablePosition epidermis, TablePosition dermis, float transmittance,
                 bool black_tape) const noexcept;
  // Whether any light crosses the epidermis unscattered.
  bool has_ballistic() const noexcept { return has_ballistic_; }
  using Totals = std::array<float, kTableSize + 1>;  // the last twice, so that index + 1 always exists
  const Totals& t1_ballistic() const noexcept { return t1_ballistic_; }
  const Totals& r1_backward(bool black_tape) const noexcept {
    return black_tape ? r1_backward_black_ : r1_backward_;
  }
  const Totals& r2_diffuse() const noexcept { return r2_diffuse_; }

 private:
  static float At(const Totals& totals, TablePosition p) noexcept {
    return totals[p.index] + p.fraction * (totals[p.index + 1] - totals[p.index]);
  }

  Totals r1_forward_, t1_forward_, t1_ballistic_, r1_backward_, r1_backward_black_, t1_backward_, r2_diffuse_,
      r2_normal_;
  bool has_ballistic_ = false;
};

}  // namespace dermap
