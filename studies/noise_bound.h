// SPDX-License-Identifier: Apache-2.0
// What noise alone lets a fit know: the yardstick of the studies of fits.
#pragma once

#include <array>
#include <vector>

#include "common/transport/forward_model.h"
#include "fit/options.h"

namespace dermap {

// One standard deviation of every parameter: Cramer-Rao's bound of a pixel by itself with the range of [D08
// table 1] as prior (variance range^2 / 12), from the closed-form Jacobian at the truth. The sideways spread
// of light is left out: fine detail is known worse, areas better. `noise`: one standard deviation,
// reflectance, one plane a band, of the maps' shape.
ParameterVector PixelNoiseBound(const ForwardModel& model, const ParameterMaps& truth,
                                const std::vector<PlaneF>& noise, std::size_t pixel);

// Its median over a sample of the pixels.
ParameterVector NoiseBound(const ForwardModel& model, const ParameterMaps& truth,
                           const std::vector<PlaneF>& noise);

// Median of |found - truth| of every parameter over the pixels where `use` is not 0 (empty: all).
ParameterVector MedianErrors(const ParameterMaps& found, const ParameterMaps& truth,
                             const std::vector<char>& use = {});

// A Gaussian's median of |error| over its standard deviation, and what a tenth of them exceeds.
inline constexpr double kMedianOverSigma = 0.6745, kDecileOverSigma = 1.6449;

double MedianOrNaN(std::vector<double> values);                  // NaN of none
double QuantileOrNaN(std::vector<double> values, double share);  // share below 1

}  // namespace dermap
