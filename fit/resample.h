// SPDX-License-Identifier: Apache-2.0
// Changing the size of a fit: area averages downwards, linear interpolation upwards.
#pragma once

#include <vector>

#include "common/tissue/parameters.h"
#include "fit/prepare.h"

namespace dermap {

// Averages areas such that the longer side has `size` pixels (a size not below the present one returns the
// data as they are); pixels stay square. Missing data have no weight, and a new pixel of which less than half
// is known is missing. Sigma is propagated with the correlation of neighbours that the data state
// (calibration's resampling makes it), and so is that correlation itself; without a statement the noise is
// taken as independent.
FitData ReduceData(const FitData& data, int size, int free_count);

// Variance of the mean of side x side pixels over what it were if their noise were independent.
double MeanNoiseInflation(const FitData& data, double side);

// Averaging over areas does not commute with the model: a reduced patch is off by about this share of its
// reflectance (measured on simulated light and medium skin reduced from 256^2 to 64^2), which sigma must hold
// beside the noise.
inline constexpr double kReductionError = 0.002;
// An error of this share of the reflectance, into sigma.
void AddRelativeError(FitData& data, double share);

// The plane at width x height over the same area, linear between the centres of pixels, constant beyond the
// outer ones.
PlaneF ResizeLinear(const PlaneF& plane, int width, int height);
ParameterMaps ResizeLinear(const ParameterMaps& maps, int width, int height);

}  // namespace dermap
