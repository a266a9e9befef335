// SPDX-License-Identifier: Apache-2.0
// What a filter's width does to a band's reflectance, and what tables get wrong about both layers together
// (TotalsCorrection): the ratio of the true mean over the filter to what the centre's tables say.
//
// Over a filter's width lateral transport hardly changes, absorption may, so the ratio is taken from uniform
// skin. It is a smooth function of the skin, within a few percent of 1, and is kept as a polynomial in the
// logarithms of both layers' absorption (degree 4), in the shares that eumelanin, blood and carotene have in
// the epidermis's, and in what the junction lets through (degree 2), fitted to closed forms over all of table
// 1 [D08].
#pragma once

#include <array>
#include <vector>

#include "common/transport/forward_model.h"

namespace dermap {

class FilterWidth {
 public:
  FilterWidth() = default;
  explicit FilterWidth(const BandOptics& band);

  bool empty() const { return coefficients_.empty(); }  // neither width nor correction: the ratio is 1
  double error() const { return error_; }               // rms over table 1, of the ratio

  // The skin of a render; `mu_a` are the centre's, 1/mm, `transmittance` is A of the junction.
  struct Skin {
    const ParameterMaps& maps;
    const PlaneF &mu_a_epidermis, &mu_a_dermis, &transmittance;
  };
  // reflectance *= ratio
  void Multiply(const Skin& skin, PlaneF& reflectance) const;
  // The ratio in every pixel, and its derivatives by the five parameters and by the junction's transmittance.
  void Derivatives(const Skin& skin, PlaneF& ratio, std::array<PlaneF, kParameterCount + 1>& gradient) const;

 private:
  void Fit(const BandOptics& band);
  void ToParameters(const Skin& skin, std::array<PlaneF, kParameterCount + 1>& gradient) const;

  Absorbers center_;
  // Means over the filter: carotene's absorption may end within it.
  float eumelanin_ = 0.0f, blood_ = 0.0f, carotene_ = 0.0f;
  float log_middle_[2] = {}, log_scale_[2] = {};  // of mu_a: what makes the logarithms -1 to 1
  std::vector<float> coefficients_;
  double error_ = 0.0;
};

}  // namespace dermap
