// SPDX-License-Identifier: Apache-2.0
// The free parameters of a fit in scaled units, in which one step length suits all of them.
#pragma once

#include <array>
#include <vector>

#include "common/tissue/parameters.h"

namespace dermap {

// By free parameter, in scaled units; the first count() count.
using FreeVector = std::array<double, kUnknownCount>;
using FreeMatrix = std::array<FreeVector, kUnknownCount>;

// The parameters of one pixel, indexed by Parameter: table 1's five and the junction's absorbance.
using SkinPoint = std::array<double, kUnknownCount>;
ParameterVector TableOne(const SkinPoint& point);
SkinPoint PointOf(const ParameterVector& p, double junction_absorbance);

// Scaled units are the standard deviation of a uniform distribution over the range of [D08 table 1], range /
// sqrt(12). So to know only that a parameter lies within its range is a variance of about 1.
class ParameterSpace {
 public:
  explicit ParameterSpace(std::vector<Parameter> free);

  int count() const { return static_cast<int>(free_.size()); }
  const std::vector<Parameter>& free() const { return free_; }
  Parameter parameter(int j) const { return free_[j]; }
  bool HasJunction() const;
  double scale(int j) const { return scale_[j]; }  // parameter's unit per scaled unit
  const FreeVector& lower() const { return lower_; }
  const FreeVector& upper() const { return upper_; }
  const FreeVector& mean() const { return mean_; }  // of average skin

  FreeVector FromParameters(const SkinPoint& p) const;
  // Writes the free parameters of `p`, held within their bounds, and leaves the others.
  void ToParameters(const FreeVector& u, SkinPoint& p) const;

 private:
  std::vector<Parameter> free_;
  FreeVector scale_{}, lower_{}, upper_{}, mean_{};
};

// `base_absorbance`: the junction's where the maps have no plane of it. Of a plane a band the first counts.
SkinPoint PointAt(const ParameterMaps& maps, std::size_t pixel, double base_absorbance);
// The junction's absorbance is written where the maps have a gray plane of it.
void SetPointAt(ParameterMaps& maps, std::size_t pixel, const SkinPoint& p);

}  // namespace dermap
