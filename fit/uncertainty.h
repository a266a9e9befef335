// SPDX-License-Identifier: Apache-2.0
// Error bars and flags of a finished fit.
#pragma once

#include "common/core/image.h"
#include "fit/fit_result.h"
#include "fit/patch_problem.h"

namespace dermap {

// One standard deviation of every free parameter, from the pixel's own normal matrix: the Jacobian of uniform
// skin scaled by what the render says the pixel really reflects, dR/dp = R_render / R_local * dR_local/dp. A
// parameter is known to lie within its range before any measurement, which counts as a variance of range^2 /
// 12: no sigma is larger than range / sqrt(12). What is left out: the blur of the transport. One pixel's
// detail is known worse than sigma says, the mean of an area several mean free paths wide much better.
ParameterMaps StandardDeviations(const PatchProblem& problem, const FitState& state);

// The same of a fit that knows its variances (of the free parameters, scaled units).
ParameterMaps SigmaMaps(const PatchProblem& problem, const std::vector<PlaneF>& variance);

// A sigma that is so many times what noise alone would leave: the model does not explain the data, and how
// far it is off is a guess.
inline constexpr double kUnexplainedWidening = 4.0;
// Sets kFlagUnexplained. `noise_variance`: of each free parameter by noise alone, scaled units; empty: not
// known, and nothing is flagged.
void FlagUnexplained(const PatchProblem& problem, const std::vector<PlaneF>& noise_variance,
                     const ParameterMaps& sigma, Plane<std::uint32_t>& flags);

// Sets a flag in every fitted pixel.
void FlagAll(const PatchProblem& problem, FitFlag flag, Plane<std::uint32_t>& flags);

// Sets kFlagAtBound, kFlagNotConverged, kFlagNotIdentifiable and kFlagOutsideValidity beside the flags that
// the data brought.
Plane<std::uint32_t> FlagsOf(const PatchProblem& problem, const FitState& state, const ParameterMaps& sigma);

// A pixel with a chi2 per datum above this was not explained by the model.
inline constexpr double kUnexplainedChi2 = 5.0;

}  // namespace dermap
