// SPDX-License-Identifier: Apache-2.0
// What data say against residuals of which maps have taken their part.
#pragma once

#include <vector>

#include "fit/detail_model.h"
#include "fit/octave_levels.h"

namespace dermap {

// How far what is told may be off before anything is seen, logarithm.
inline constexpr double kExpectedError = 0.3;

// A residual (logarithms) and what is left of it once maps have made up for what they can, at the price of
// their distance from the prior (scaled units).
struct Answered {
  std::vector<PlaneF> left, distance;
};

// What the data say against both at once: u' (noise + maps' prior)^-1 v, where maps made up for all they can.
double Product(const std::vector<OctaveLevel>& levels, const ParameterSpace& space, const DetailView& detail,
               const Answered& u, const Answered& v);

// Logarithm by which the data prefer that what is told is off by `error`, known to `sigma`.
double LogEvidence(double error, double sigma);

}  // namespace dermap
