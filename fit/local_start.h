// SPDX-License-Identifier: Apache-2.0
// Closed-form local inversion: every pixel by itself, as if all the skin were like it.
#pragma once

#include "fit/patch_problem.h"

namespace dermap {

// Damped Gauss-Newton on ForwardModel::LocalReflectance in logarithms, within the bounds. A weak prior
// (average skin, with the variance that table 1's ranges have) decides what the data leave open. Costs no
// render. What is not free takes its value from `fixed`; masked pixels are their neighbours' mean.
ParameterMaps InvertLocally(const PatchProblem& problem, const ParameterVector& fixed);

// The same on area averages of about `size` pixels along the longer side, interpolated: without the noise of
// single pixels, which would send what they hardly determine to its bounds, from where descent returns
// slowly.
ParameterMaps InvertAverages(const PatchProblem& problem, const ParameterVector& fixed, int size);

// The same for one pixel, from `start`; returns the iterations it took.
int InvertPixel(const PatchProblem& problem, std::size_t pixel, SkinPoint& p);

}  // namespace dermap
