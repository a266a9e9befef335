// SPDX-License-Identifier: Apache-2.0
// The numbers of the report: quantiles of maps, error against truth, and the points whose spectra are drawn.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/core/image.h"
#include "common/files/maps.h"
#include "fit/fit_result.h"

namespace dermap {

// One map as the report shows it: a parameter of [D08 table 1], or the junction's absorbance (gray or of one
// band).
struct ReportedMap {
  std::string name;
  std::string description;
  std::string unit;
  bool free = false;
  const PlaneF* value = nullptr;
  const PlaneF* sigma = nullptr;  // null where the fit has none
  std::optional<PlaneF> truth;    // at the size of the fit
};
std::vector<ReportedMap> ReportedMaps(const FitResult& fit, const MapsFile* truth);

// Quantile of the finite values, by rank; NaN without any.
double QuantileOf(std::span<const float> values, double share);

// How far a map is from the truth, over the pixels that the fit did not mask. Relative errors leave out
// pixels whose true value is 0.
struct TruthError {
  double median_absolute = 0.0;
  double median_relative = 0.0;
  double percentile_90_relative = 0.0;
  double bias_relative = 0.0;         // median of the signed relative error
  double share_within_1_sigma = 0.0;  // 0.68 where the error bars are right
  double share_within_2_sigma = 0.0;  // 0.95
  int pixels = 0;
};
TruthError CompareToTruth(const ReportedMap& map, const Plane<std::uint32_t>& flags);

// Pixels worth a look, at least a twentieth of the patch away from its border and not masked: where the mean
// over 3 x 3 pixels of a map is least or most.
struct NamedPoint {
  char letter = 'A';
  std::string name;  // "least melanin"
  int x = 0, y = 0;
};
std::vector<NamedPoint> NamedPoints(const FitResult& fit);

// Mean over 3 x 3 pixels (less at the border) of the finite values.
double MeanAround(const PlaneF& plane, int x, int y);
// Mean of the finite values; NaN without any.
double MeanOf(const PlaneF& plane);
// The plane with NaN wherever `reference` has no finite value: for means over the same pixels.
PlaneF WhereFinite(const PlaneF& plane, const PlaneF& reference);
// The plane with NaN wherever the fit masked the pixel: scales and quantiles are those of what was measured.
PlaneF WithoutMasked(const PlaneF& plane, const Plane<std::uint32_t>& flags);

}  // namespace dermap
